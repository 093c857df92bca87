#include "kinect_ekf_slam/perception/fiducial.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/unit/perception/rendered.h"

namespace kinect_ekf_slam {
namespace {

/// Turned about the vertical by `slant` against facing the camera, which stands over the origin.
Panel panel(int identity, const Eigen::Vector3d& center, double slant) {
  const FiducialOptions options;
  const std::vector<std::string> pattern = fiducial_pattern(options.dictionary, identity);
  const auto modules = static_cast<double>(pattern.size());
  const double facing = std::atan2(-center.y(), -center.x()) + slant;
  return upright_panel(center, facing, options.side * (modules + 2.0) / modules, printed(pattern));
}

RgbdPicture photograph_sharply(const Scene& scene, const Eigen::Isometry3d& camera, std::uint64_t seed) {
  RgbdCameraOptions options;
  options.samples = 3;
  return testing::photograph(scene, camera, seed, true, options);
}

TEST(Fiducial, IdentityAndPlaceAreRightFromAllDistancesAndSlants) {
  const Eigen::Isometry3d camera = testing::camera_at(0.3, 0.0);
  int identity = 0;
  double squared = 0.0;
  int count = 0;
  for (const double distance : {0.5, 1.0, 1.7, 2.5}) {
    for (const double slant_deg : {-60.0, -30.0, 0.0, 45.0}) {
      identity = (identity + 7) % 50;
      const Eigen::Vector3d center(distance, 0.1 * distance, 0.3);
      Scene scene = testing::floor_and_wall();
      scene.panels.push_back(panel(identity, center, radians(slant_deg)));
      const Findings findings = FiducialDetector({}).detect(photograph_sharply(scene, camera, identity));
      ASSERT_EQ(findings.found.size(), 1U) << distance << " m, " << slant_deg << " deg";
      const Finding& finding = findings.found[0];
      EXPECT_EQ(finding.signature.source_id, identity);
      const Eigen::Vector3d error = finding.position - camera.inverse() * center;
      EXPECT_LT(error.norm(), 0.01 * distance) << distance << " m, " << slant_deg << " deg";
      EXPECT_TRUE(testing::IsCovariance(finding.covariance));
      squared += error.dot(finding.covariance.ldlt().solve(error));
      ++count;
    }
  }
  EXPECT_LT(squared / count, 6.0);  // 3 expected
}

TEST(Fiducial, DistanceIsLessSureThanDirection) {
  Scene scene = testing::floor_and_wall();
  scene.panels.push_back(panel(3, {2.0, 0.0, 0.3}, 0.0));
  const Findings findings =
      FiducialDetector({}).detect(photograph_sharply(scene, testing::camera_at(0.3, 0.0), 1));
  ASSERT_EQ(findings.found.size(), 1U);
  EXPECT_GT(findings.found[0].covariance(2, 2), 3.0 * findings.found[0].covariance(0, 0));
}

TEST(Fiducial, FindsNoneWhereThereIsNone) {
  Scene scene = testing::floor_and_wall();
  scene.panels.push_back({{2.0, 1.0, 1.0}, {0.0, -2.0, 0.0}, {0.0, 0.0, -1.0}, blotches(200, 100, 4)});
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const RgbdPicture picture = photograph_sharply(scene, testing::camera_at(0.3, 0.0), seed);
    EXPECT_TRUE(FiducialDetector({}).detect(picture).found.empty());
  }
}

TEST(Fiducial, RefusesWhatItCannotUse) {
  FiducialOptions options;
  options.dictionary = "9X9";
  EXPECT_THROW(FiducialDetector{options}, std::invalid_argument);
  EXPECT_THROW(fiducial_pattern("9X9", 0), std::invalid_argument);
  EXPECT_THROW(fiducial_pattern("4X4_50", 50), std::invalid_argument);
  EXPECT_EQ(fiducial_pattern("4X4_50", 0).size(), 6U);
  RgbdPicture picture;
  picture.depth = cv::Mat(4, 4, CV_16UC1, cv::Scalar(1000));
  EXPECT_THROW(FiducialDetector({}).detect(picture), PictureError);
}

}  // namespace
}  // namespace kinect_ekf_slam
