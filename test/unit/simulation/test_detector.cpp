#include <gtest/gtest.h>

#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/simulator.h"
#include "test/support/matchers.h"
#include "test/unit/simulation/small_world.h"

namespace kinect_ekf_slam::testing {
namespace {

constexpr int kFrames = 10000;

/// A count of `trials` with `probability` within five standard deviations: fails by chance once in a million.
void expect_binomial(int count, int trials, double probability) {
  const double sigma = std::sqrt(trials * probability * (1.0 - probability));
  EXPECT_NEAR(count, trials * probability, 5.0 * sigma);
}

double report_variance(double depth) { return (0.00471429 * depth - 0.0106429) * depth + 0.00714286; }

TEST(Detector, SeesWhatIsInViewAndNothingElse) {
  World world = exact_world();
  const double edge = std::tan(radians(28.5));
  int id = 0;
  for (const double forward : {0.55, 0.65, 1.5, 2.55, 2.65}) {
    for (const double share : {-1.05, -0.95, 0.0, 0.95, 1.05}) {
      world.landmarks = {cylinder(++id, forward, share * edge * forward)};
      const auto sightings = pictures(world, 1, 1).front();
      const bool visible = forward > 0.6 && forward < 2.6 && std::abs(share) < 1.0;
      EXPECT_EQ(sightings.size(), visible ? 1U : 0U) << forward << " m, " << share << " of the edge";
    }
  }
}

TEST(Detector, ReportsInOpticalAxes) {
  World world = exact_world();
  world.sensor.base_from_optical.translation() = Eigen::Vector3d(0.1, 0.0, 0.25);
  world.landmarks = {cylinder(4, 1.6, 0.3, 0.07)};
  world.landmarks.front().position_in_world.z() = 0.15;
  const Sighting sighting = pictures(world, 1, 1).front().front();
  EXPECT_TRUE(MatrixNear(sighting.position_in_optical, Eigen::Vector3d(-0.3, 0.1, 1.5), 1e-12));
  EXPECT_DOUBLE_EQ(sighting.radius, 0.07);
  EXPECT_EQ(sighting.label, "red");
  EXPECT_EQ(sighting.id, 4);
  const Detection detection = to_detection(sighting, world.sensor.base_from_optical);
  EXPECT_TRUE(MatrixNear(detection.position_in_base, Eigen::Vector3d(1.6, 0.3, 0.15), 1e-12));
}

TEST(Detector, NoiseIsTheReports) {
  for (const double depth : {0.8, 1.2, 2.5}) {
    World world = exact_world();
    world.landmarks = {cylinder(1, depth, 0.0)};
    for (const double scale : {1.0, 0.5}) {
      world.sensor.noise_scale = scale;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
      for (const auto& picture : pictures(world, 5, kFrames)) {
        const Eigen::Vector3d error = picture.front().position_in_optical - Eigen::Vector3d(0.0, 0.0, depth);
        sum += error;
        squares += error * error.transpose();
      }
      const double variance = scale * scale * report_variance(depth);
      EXPECT_TRUE(MatrixNear(sum / kFrames, Eigen::Vector3d::Zero(), 5.0 * std::sqrt(variance / kFrames)));
      EXPECT_TRUE(MatrixNear(squares / kFrames, variance * Eigen::Matrix3d::Identity(),
                             5.0 * variance * std::sqrt(2.0 / kFrames)));
      EXPECT_TRUE(MatrixNear(pictures(world, 5, 1).front().front().covariance_in_optical,
                             variance * Eigen::Matrix3d::Identity(), 1e-12));
    }
  }
}

TEST(Detector, LeavesOutCovarianceAndIdentityWhenTold) {
  World world = exact_world();
  world.landmarks = {cylinder(1, 1.0, 0.0)};
  world.sensor.noise_scale = 1.0;
  world.sensor.reports_covariance = false;
  world.sensor.reports_identity = false;
  const Sighting sighting = pictures(world, 1, 1).front().front();
  EXPECT_TRUE(sighting.covariance_in_optical.isZero(0.0));
  EXPECT_EQ(sighting.id, kNoId);
}

TEST(Detector, MissesAtItsRate) {
  World world = exact_world();
  world.landmarks = {cylinder(1, 1.0, 0.0)};
  world.sensor.miss_rate = 0.2;
  int missed = 0;
  for (const auto& picture : pictures(world, 1, kFrames)) missed += picture.empty() ? 1 : 0;
  expect_binomial(missed, kFrames, 0.2);
}

TEST(Detector, TakesForAnotherColourAtItsRate) {
  World world = exact_world();
  world.landmarks = {cylinder(1, 1.0, 0.0), cylinder(2, -1.0, 0.0)};  // only the blue one is in view
  world.sensor.wrong_label_rate = 0.1;
  int wrong = 0;
  for (const auto& picture : pictures(world, 1, kFrames)) {
    ASSERT_EQ(picture.size(), 1U);
    wrong += picture.front().label == "red" ? 1 : 0;
  }
  expect_binomial(wrong, kFrames, 0.1);
}

TEST(Detector, IsFarOffAtItsRateAndNotFarther) {
  World world = exact_world();
  world.landmarks = {cylinder(1, 1.5, 0.0)};
  world.sensor.gross_error_rate = 0.05;
  int gross = 0;
  double largest = 0.0;
  for (const auto& picture : pictures(world, 1, kFrames)) {
    const double error = (picture.front().position_in_optical - Eigen::Vector3d(0.0, 0.0, 1.5)).norm();
    gross += error > 1e-9 ? 1 : 0;
    largest = std::max(largest, error);
  }
  expect_binomial(gross, kFrames, 0.05);
  EXPECT_GT(largest, 1.9);
  EXPECT_LE(largest, 2.0);
}

TEST(Detector, ImaginesAtItsRateAndInView) {
  World world = exact_world();
  world.landmarks = {cylinder(1, -1.0, 0.0)};
  world.sensor.false_per_minute = 30.0;
  int imagined = 0;
  for (const auto& picture : pictures(world, 1, kFrames)) {
    for (const Sighting& sighting : picture) {
      ++imagined;
      const Eigen::Vector3d& position = sighting.position_in_optical;
      EXPECT_EQ(sighting.id, kNoId);
      EXPECT_TRUE(position.z() >= 0.6 && position.z() <= 2.6);
      EXPECT_LE(std::abs(position.x()), std::tan(radians(28.5)) * position.z());
    }
  }
  expect_binomial(imagined, kFrames, 30.0 / (60.0 * world.sensor.rate));
}

TEST(Detector, ACylinderHidesWhatIsBehindIt) {
  World world = exact_world();
  world.landmarks = {cylinder(1, 1.0, 0.0, 0.1), cylinder(2, 2.0, 0.15), cylinder(3, 2.0, -0.25)};
  const auto sightings = pictures(world, 1, 1).front();
  ASSERT_EQ(sightings.size(), 2U);
  EXPECT_EQ(sightings[0].id, 1);
  EXPECT_EQ(sightings[1].id, 3);
}

}  // namespace
}  // namespace kinect_ekf_slam::testing
