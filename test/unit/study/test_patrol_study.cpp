#include "kinect_ekf_slam/study/patrol_study.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace kinect_ekf_slam {
namespace {

TEST(PatrolStudy, GoesOnBeyondTheWorldsOwnLoops) {
  PatrolStudy study;
  study.world = read_world(
      (std::filesystem::path(__FILE__).parent_path() / "../../../config/worlds/room.yaml").string());
  study.minutes = 12;
  const std::vector<PatrolStretch> patrol = run_study(study);
  ASSERT_EQ(patrol.size(), 12U);
  EXPECT_NEAR(patrol.back().minutes, 12.0, 0.01);
  EXPECT_GE(patrol.back().landmarks, 10U);
  for (const PatrolStretch& stretch : patrol) EXPECT_GT(stretch.update_ms, 0.0);
}

TEST(PatrolStudy, FlatIsNoMoreLandmarksMemoryOrTime) {
  const PatrolStretch start{5.0, 10, 60.0, 0.10};
  EXPECT_TRUE(is_flat({start, {60.0, 10, 60.5, 0.11}}));
  EXPECT_FALSE(is_flat({start, {60.0, 12, 60.0, 0.10}}));
  EXPECT_FALSE(is_flat({start, {60.0, 10, 62.0, 0.10}}));
  EXPECT_FALSE(is_flat({start, {60.0, 10, 60.0, 0.15}}));
}

}  // namespace
}  // namespace kinect_ekf_slam
