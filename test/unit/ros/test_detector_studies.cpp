#include <gtest/gtest.h>

#include "kinect_ekf_slam/study/cylinder_study.h"
#include "kinect_ekf_slam/study/fiducial_study.h"

namespace kinect_ekf_slam {
namespace {

TEST(CylinderStudy, AFewViewsReachWhatManyMust) {
  CylinderStudy study;
  study.palette = read_palette(std::string(CONFIG_FOLDER) + "/palette.yaml");
  study.views = 40;
  const CylinderStudyResult result = run_study(study);
  EXPECT_GT(result.expected, 30);
  EXPECT_GE(result.recall(), 0.97);
  EXPECT_GE(result.precision(), 0.95);
  EXPECT_EQ(result.wrong_labels, 0);
  EXPECT_LT(result.center_rmse, 0.012);
  EXPECT_GT(result.nees_mean, 2.0);
  EXPECT_LT(result.nees_mean, 4.0);
}

TEST(FiducialStudy, AFewViewsReachWhatManyMust) {
  FiducialStudy study;
  study.views = 20;
  const FiducialStudyResult result = run_study(study);
  EXPECT_GE(result.found, 19);
  EXPECT_EQ(result.wrong_identities, 0);
  EXPECT_EQ(result.within_one_percent, result.found);
}

}  // namespace
}  // namespace kinect_ekf_slam
