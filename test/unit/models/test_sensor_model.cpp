#include "kinect_ekf_slam/models/sensor_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

/// A sensor somewhere on the robot; its optical frame has Z forward, X right, Y down.
Eigen::Isometry3d mounting(const Eigen::Vector3d& position, double yaw) {
  Eigen::Isometry3d base_from_optical = Eigen::Isometry3d::Identity();
  base_from_optical.translation() = position;
  Eigen::Matrix3d body_from_optical;
  body_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  base_from_optical.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * body_from_optical;
  return base_from_optical;
}

Detection seen_at(const Eigen::Vector3d& point_in_optical,
                  const Eigen::Isometry3d& base_from_optical = mounting({0.0, 0.0, 0.3}, 0.0)) {
  Detection detection;
  detection.position_in_optical = point_in_optical;
  detection.position_in_base = base_from_optical * point_in_optical;
  detection.base_from_optical = base_from_optical.linear();
  return detection;
}

double up(double value) { return std::nextafter(value, 1e9); }
double down(double value) { return std::nextafter(value, -1e9); }

TEST(RangeGate, IsClosedAtItsEnds) {
  const SensorOptions options;
  EXPECT_TRUE(in_range(seen_at({0.0, 0.0, 0.6}), options));
  EXPECT_TRUE(in_range(seen_at({0.0, 0.0, 2.6}), options));
  EXPECT_TRUE(in_range(seen_at({2.5, 0.0, 1.0}), options));
  EXPECT_TRUE(in_range(seen_at({-2.5, 0.0, 1.0}), options));
  EXPECT_FALSE(in_range(seen_at({0.0, 0.0, down(0.6)}), options));
  EXPECT_FALSE(in_range(seen_at({0.0, 0.0, up(2.6)}), options));
  EXPECT_FALSE(in_range(seen_at({up(2.5), 0.0, 1.0}), options));
  EXPECT_FALSE(in_range(seen_at({down(-2.5), 0.0, 1.0}), options));
}

TEST(RangeGate, IsAskedInTheOpticalFrame) {
  // 1 m in front of a camera that looks backwards from 2 m behind the robot's centre: 3 m from the centre.
  const Detection behind = seen_at({0.0, 0.0, 1.0}, mounting({-2.0, 0.0, 0.3}, kPi));
  EXPECT_NEAR(behind.position_in_base.x(), -3.0, 1e-12);
  EXPECT_TRUE(in_range(behind, {}));
  EXPECT_FALSE(in_range(seen_at({0.0, 0.0, -1.0}), {})) << "behind the camera";
  EXPECT_TRUE(in_range(seen_at({0.0, 9.0, 1.0}), {})) << "height is not gated";
}

TEST(RangeGate, RefusesWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(in_range(seen_at({0.0, 0.0, nan}), {}));
  EXPECT_FALSE(in_range(seen_at({nan, 0.0, 1.0}), {}));
}

TEST(DepthModel, IsTheReportsQuadratic) {
  for (const auto& [depth, variance] :
       {std::pair(0.6, 0.0024543), std::pair(1.0, 0.00121425), std::pair(1.1288, 0.0011360),
        std::pair(2.0, 0.0047142), std::pair(2.6, 0.0113400)}) {
    const Detection detection = with_noise(seen_at({0.3, -0.2, depth}), {});
    EXPECT_TRUE(MatrixNear(detection.covariance_in_base, variance * Eigen::Matrix3d::Identity(), 1e-6))
        << depth;
  }
}

TEST(DepthModel, IsPositiveAtAnyDepth) {
  for (double depth = -5.0; depth < 10.0; depth += 0.01) {
    EXPECT_GT(with_noise(seen_at({0.0, 0.0, depth}), {}).covariance_in_base(0, 0), 0.0) << depth;
  }
}

TEST(DepthModel, UsesTheDepthAndNotTheDistanceFromTheRobot) {
  const Detection far_sensor = with_noise(seen_at({0.0, 0.0, 1.0}, mounting({5.0, 3.0, 1.0}, 2.0)), {});
  EXPECT_NEAR(far_sensor.covariance_in_base(0, 0), 0.00121425, 1e-8);
}

SensorOptions range_bearing() {
  SensorOptions options;
  options.model = SensorOptions::Model::kRangeBearing;
  options.range_noise = 0.03;
  options.range_noise_per_meter = 0.02;
  options.bearing_noise_deg = 1.0;
  return options;
}

TEST(RangeBearingModel, IsAlongAndAcrossTheRay) {
  const Eigen::Vector3d point(1.2, -0.4, 1.6);
  const Detection detection = with_noise(seen_at(point), range_bearing());
  const Eigen::Vector3d along = (detection.base_from_optical * point).normalized();
  const Eigen::Vector3d across = along.unitOrthogonal();
  const double range = point.norm();
  const Eigen::Matrix3d& covariance = detection.covariance_in_base;
  EXPECT_NEAR(along.dot(covariance * along), 0.03 * 0.03 + std::pow(0.02 * range, 2), 1e-12);
  EXPECT_NEAR(across.dot(covariance * across), std::pow(range * radians(1.0), 2), 1e-12);
  EXPECT_NEAR(along.dot(covariance * across), 0.0, 1e-12);
}

/// A sensor that stands far from the robot's centre and is turned: its noise turns with it, its place does
/// not matter.
TEST(RangeBearingModel, TurnsWithTheSensor) {
  const Eigen::Vector3d ahead(0.0, 0.0, 2.0);
  const double along = 0.03 * 0.03 + std::pow(0.02 * 2.0, 2);
  const double across = std::pow(2.0 * radians(1.0), 2);
  for (const Eigen::Vector3d& position : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-4.0, 2.0, 1.0)}) {
    const auto left = with_noise(seen_at(ahead, mounting(position, 0.5 * kPi)), range_bearing());
    EXPECT_TRUE(
        MatrixNear(left.covariance_in_base.diagonal(), Eigen::Vector3d(across, along, across), 1e-12));
    const auto diagonal = with_noise(seen_at(ahead, mounting(position, 0.25 * kPi)), range_bearing());
    EXPECT_NEAR(diagonal.covariance_in_base(0, 1), 0.5 * (along - across), 1e-12);
  }
}

TEST(RangeBearingModel, HoldsNowhereAtTheSensorItself) {
  EXPECT_TRUE(with_noise(seen_at({0.0, 0.0, 0.0}), range_bearing()).covariance_in_base.isZero(0.0));
}

TEST(NoiseSource, TheMessagesCovarianceIsUsedUntilTheModelIsAskedFor) {
  Detection detection = seen_at({0.0, 0.0, 1.0});
  detection.covariance_in_base = 0.5 * Eigen::Matrix3d::Identity();
  SensorOptions options;
  EXPECT_TRUE(
      MatrixNear(with_noise(detection, options).covariance_in_base, detection.covariance_in_base, 0.0));
  options.noise_source = SensorOptions::NoiseSource::kModel;
  EXPECT_NEAR(with_noise(detection, options).covariance_in_base(0, 0), 0.00121425, 1e-8);
}

TEST(NoiseSource, AMessageWithoutCovarianceGetsTheModels) {
  EXPECT_NEAR(with_noise(seen_at({0.0, 0.0, 1.0}), {}).covariance_in_base(0, 0), 0.00121425, 1e-8);
}

TEST(RangeScale, StretchesTheRayFromTheSensorNotFromTheRobot) {
  SensorOptions options;
  options.range_scale = 1.1;
  const Eigen::Isometry3d base_from_optical = mounting({-2.0, 1.0, 0.4}, kPi);
  const Eigen::Vector3d point(0.5, 0.1, 2.0);
  const Detection detection = with_noise(seen_at(point, base_from_optical), options);
  EXPECT_TRUE(
      MatrixNear(detection.position_in_base, base_from_optical * Eigen::Vector3d(1.1 * point), 1e-12));
  EXPECT_TRUE(MatrixNear(detection.position_in_optical, 1.1 * point, 1e-12));
}

TEST(DepthShare, MakesADistanceOfADepth) {
  SensorOptions options;
  options.depth_share = 1.0;
  const Eigen::Vector3d point(1.0, 0.5, 2.0);
  const double depth = 2.0;
  const Eigen::Vector3d told = depth * point.normalized();  // the right direction, the depth for a distance
  EXPECT_TRUE(MatrixNear(with_range_corrected(seen_at(told), options).position_in_optical, point, 1e-12));
  const Eigen::Vector3d ahead(0.0, 0.0, 2.0);
  EXPECT_TRUE(MatrixNear(with_range_corrected(seen_at(ahead), options).position_in_optical, ahead, 0.0));
  options.depth_share = 0.0;
  EXPECT_TRUE(MatrixNear(with_range_corrected(seen_at(told), options).position_in_optical, told, 0.0));
  EXPECT_TRUE(obliquity({1.0, 0.0, -1.0}) > 1.0 && obliquity({1.0, 0.0, 0.0}) > 1.0)
      << "finite beside and behind";
}

}  // namespace
}  // namespace kinect_ekf_slam
