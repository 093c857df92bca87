#include "kinect_ekf_slam/ros/spelling.h"

#include <gtest/gtest.h>

namespace kinect_ekf_slam {
namespace {

TEST(EditDistance, CountsLettersPutInTakenOutAndReplaced) {
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("abc", ""), 3);
  EXPECT_EQ(edit_distance("particles", "particles"), 0);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("sitting", "kitten"), 3);
}

TEST(SimilarKey, IsTheOneThatWasMeant) {
  const std::vector<std::string> known{"association/type",    "mode",
                                       "sensor/max_depth",    "sensor/min_depth",
                                       "estimator/particles", "estimator/type"};
  EXPECT_EQ(similar_key("sensor/max_dpth", known), "sensor/max_depth");
  EXPECT_EQ(similar_key("estimatr/partikles", known), "estimator/particles");
  EXPECT_EQ(similar_key("filter/particles", known), "estimator/particles") << "the wrong group";
  EXPECT_EQ(similar_key("estimatr/type", known), "estimator/type") << "not the first of that name";
  EXPECT_EQ(similar_key("particles", known), "estimator/particles") << "no group";
  EXPECT_EQ(similar_key("Mode", known), "mode");
  EXPECT_EQ(similar_key("odom_frame", known), "") << "another program's";
}

}  // namespace
}  // namespace kinect_ekf_slam
