#include "kinect_ekf_slam/perception/kinect_cylinder.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "test/support/matchers.h"
#include "test/unit/perception/rendered.h"

namespace kinect_ekf_slam {
namespace {

using testing::camera_at;
using testing::floor_and_wall;
using testing::photograph;
using testing::standing;

const Palette& palette() {
  static const Palette kPalette =
      parse_palette("colours: {red: [340, 20], green: [80, 160], blue: [200, 260]}", "test");
  return kPalette;
}

Findings detect(const RgbdPicture& picture, const std::optional<Eigen::Vector3d>& up = std::nullopt) {
  return KinectCylinderDetector({}, palette()).detect(picture, up);
}

bool refuses(const Findings& findings, const std::string& reason) {
  for (const Refusal& refusal : findings.refused) {
    if (refusal.reason.find(reason) != std::string::npos) return true;
  }
  return false;
}

TEST(KinectCylinder, FindsPlaceRadiusAndColour) {
  const Eigen::Isometry3d camera = camera_at(0.35, 0.15);
  Scene scene = floor_and_wall();
  scene.bodies = {standing(1.2, 0.2, 0.06, 0.4, {190, 35, 30}),
                  standing(2.2, -0.6, 0.09, 0.5, {35, 70, 180})};
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Findings findings = detect(photograph(scene, camera, seed));
    ASSERT_EQ(findings.found.size(), 2U);
    for (const Finding& finding : findings.found) {
      const RoundBody& body = scene.bodies[finding.position.z() < 1.7 ? 0 : 1];
      const Eigen::Vector3d truth = camera.inverse() * (body.foot_in_world + 0.5 * body.axis);
      EXPECT_LT((finding.position - truth).norm(), 0.012);
      EXPECT_NEAR(finding.signature.radius, body.foot_radius, 0.006);
      EXPECT_EQ(finding.signature.label, body.foot_radius < 0.07 ? "red" : "blue");
      EXPECT_GT(finding.score, 0.8);
      EXPECT_TRUE(testing::IsCovariance(finding.covariance));
      EXPECT_GT(finding.covariance.diagonal().minCoeff(), 1e-7);
    }
  }
}

TEST(KinectCylinder, IsLessSureOfWhatIsFarther) {
  Scene scene = floor_and_wall();
  scene.bodies = {standing(1.0, -0.2, 0.07, 0.35), standing(2.4, 0.3, 0.07, 0.35)};
  const Findings findings = detect(photograph(scene, camera_at(0.3, 0.1)));
  ASSERT_EQ(findings.found.size(), 2U);
  const bool first_is_near = findings.found[0].position.z() < findings.found[1].position.z();
  const Finding& near = findings.found[first_is_near ? 0 : 1];
  const Finding& far = findings.found[first_is_near ? 1 : 0];
  EXPECT_GT(far.covariance.trace(), 2.0 * near.covariance.trace());
}

TEST(KinectCylinder, RefusesWhatIsNone) {
  Scene box = floor_and_wall();
  box.add_box({1.3, 0.0}, 0.6, {0.15, 0.15, 0.3}, {200, 40, 40});
  Scene face = floor_and_wall();
  face.add_box({1.3, 0.0}, 0.0, {0.12, 0.12, 0.3}, {200, 40, 40});
  Scene bowl = floor_and_wall();
  bowl.bodies = {{{1.0, 0.0, 0.0}, {0.0, 0.0, 0.09}, 0.05, 0.1, {190, 35, 30}}};
  Scene roll = floor_and_wall();
  roll.bodies = {{{1.0, -0.1, 0.05}, {0.1, 0.2, 0.0}, 0.05, 0.05, {190, 35, 30}}};
  Scene tin_on_rim = floor_and_wall();
  tin_on_rim.bodies = {{{1.0, 0.0, 0.1}, {0.05, 0.05, 0.0}, 0.1, 0.1, {190, 35, 30}}};
  Scene legs = floor_and_wall();
  for (const double y : {-0.1, 0.1}) {
    legs.bodies.push_back({{1.4, y, 0.0}, {0.0, 0.0, 0.85}, 0.055, 0.085, {40, 50, 90}});
  }
  Scene column = floor_and_wall();
  column.bodies = {standing(1.5, 0.0, 0.25, 0.4)};
  int scene_number = 0;
  for (const Scene& scene : {box, face, bowl, roll, tin_on_rim, legs, column, floor_and_wall()}) {
    for (const double tilt : {0.1, 0.35}) {
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        EXPECT_TRUE(detect(photograph(scene, camera_at(0.5, tilt), seed)).found.empty()) << scene_number;
      }
    }
    ++scene_number;
  }
}

TEST(KinectCylinder, LowersTheScoreOfWhatIsCutOffOrHidden) {
  Scene whole = floor_and_wall();
  whole.bodies = {standing(1.2, 0.0, 0.08, 0.35)};
  const Findings of_whole = detect(photograph(whole, camera_at(0.3, 0.1)));
  ASSERT_EQ(of_whole.found.size(), 1U);

  Scene cut = floor_and_wall();
  cut.bodies = {standing(1.2, 0.7, 0.08, 0.35)};
  for (const Finding& finding : detect(photograph(cut, camera_at(0.3, 0.1))).found) {
    EXPECT_LT(finding.score, 0.6 * of_whole.found[0].score);
  }

  Scene hidden = whole;
  hidden.add_box({0.85, 0.09}, 0.0, {0.1, 0.14, 0.4}, {90, 90, 90});
  for (const Finding& finding : detect(photograph(hidden, camera_at(0.3, 0.1))).found) {
    EXPECT_LT(finding.score, 0.9 * of_whole.found[0].score);
    EXPECT_GT(finding.covariance.trace(), of_whole.found[0].covariance.trace());
  }
}

TEST(KinectCylinder, StandsOnThePlaneThatGravityNames) {
  Scene scene = floor_and_wall();
  scene.bodies = {standing(1.2, 0.0, 0.08, 0.35)};
  const Eigen::Isometry3d camera = camera_at(0.3, 0.1);
  const RgbdPicture picture = photograph(scene, camera);
  const Eigen::Vector3d up = camera.linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_EQ(detect(picture, up).found.size(), 1U);
  const Eigen::Vector3d wrong = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) * up;
  EXPECT_TRUE(detect(picture, wrong).found.empty());
  EXPECT_TRUE(refuses(detect(picture, wrong), "no supporting plane"));
}

TEST(KinectCylinder, WithoutReadingsThereIsNothing) {
  RgbdPicture picture;
  for (const float value :
       {0.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    picture.depth = cv::Mat(480, 640, CV_32FC1, cv::Scalar(value));
    EXPECT_TRUE(detect(picture).found.empty());
    EXPECT_TRUE(refuses(detect(picture), "no supporting plane"));
  }
  picture.depth = cv::Mat(1, 1, CV_16UC1, cv::Scalar(1000));
  EXPECT_TRUE(detect(picture).found.empty());
  picture.depth = cv::Mat();
  EXPECT_THROW(detect(picture), PictureError);
}

TEST(KinectCylinder, AnythingInThePictureIsNoCrash) {
  std::mt19937 random(1);
  const auto scribble = [&](cv::Mat* image) {
    for (std::size_t i = 0; i < image->total() * image->elemSize(); ++i) {
      image->data[i] = static_cast<std::uint8_t>(random());
    }
  };
  for (int i = 0; i < 200; ++i) {
    RgbdPicture picture;
    const int rows = 1 + static_cast<int>(random() % 64);
    const int columns = 1 + static_cast<int>(random() % 64);
    picture.depth.create(rows, columns, i % 2 == 0 ? CV_16UC1 : CV_32FC1);
    picture.colour.create(rows, columns, CV_8UC3);
    scribble(&picture.depth);
    scribble(&picture.colour);
    for (const Finding& finding : detect(picture).found) {
      EXPECT_TRUE(finding.position.allFinite());
      EXPECT_TRUE(finding.covariance.allFinite());
    }
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
