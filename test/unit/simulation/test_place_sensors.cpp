#include "kinect_ekf_slam/simulation/place_sensors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kinect_ekf_slam/simulation/world.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

Eigen::Isometry3d somewhere() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(3.0, -2.0, 0.0);
  pose.linear() = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

/// Noise and a drift that lasts: together the covariance that is told; between two fixes the noise alone.
TEST(GpsReceiver, ErrsAsItsCovarianceSays) {
  GpsOptions options;
  options.noise = 0.5;
  options.drift = 2.0;
  options.drift_time = 60.0;
  double squared = 0.0;
  double squared_step = 0.0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    GpsReceiver gps(options, RandomStream(static_cast<std::uint64_t>(run), 0));
    const auto first = gps.read(0, somewhere());
    const auto next = gps.read(to_nanoseconds(0.1), somewhere());
    const Eigen::Vector3d error = first.position_in_map - somewhere() * options.antenna_in_base;
    squared += error.squaredNorm() / kRuns;
    squared_step += (next.position_in_map - first.position_in_map).squaredNorm() / kRuns;
    EXPECT_NEAR(first.covariance(0, 0), 4.25, 1e-12);
    EXPECT_NEAR(first.covariance(2, 2), 17.0, 1e-12);
  }
  EXPECT_NEAR(squared, 4.25 * 6.0, 4.0);  // axes of 1, 1 and 2 sigma
  EXPECT_NEAR(squared_step, 2.0 * 0.25 * 6.0 + 2.0 * 4.0 * 6.0 * 0.1 / 60.0, 0.5);
}

TEST(GpsReceiver, JumpsNowAndThen) {
  GpsOptions options;
  options.noise = 0.001;
  options.outlier_rate = 0.1;
  GpsReceiver gps(options, RandomStream(1, 0));
  int jumps = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto fix = gps.read(i, somewhere());
    const double error = (fix.position_in_map - somewhere() * options.antenna_in_base).norm();
    jumps += std::abs(error - 20.0) < 0.1 ? 1 : 0;
  }
  EXPECT_NEAR(jumps, 100, 40);
}

TEST(RangeReceiver, MeasuresToWhatIsNear) {
  BeaconOptions options;
  options.noise = 0.1;
  options.max_range = 10.0;
  options.receiver_in_base = {0.0, 0.0, 1.0};
  options.places_in_world = {{3, {3.0, 4.0, 1.0}}, {5, {3.0, 40.0, 1.0}}};
  RangeReceiver receiver(options, RandomStream(1, 0));
  double sum = 0.0;
  double squared = 0.0;
  constexpr int kLooks = 1000;
  for (int i = 0; i < kLooks; ++i) {
    const auto ranges = receiver.read(somewhere());
    ASSERT_EQ(ranges.size(), 1U);
    EXPECT_EQ(ranges[0].beacon, 3);
    sum += (ranges[0].range - 6.0) / kLooks;
    squared += std::pow(ranges[0].range - 6.0, 2) / kLooks;
  }
  EXPECT_NEAR(sum, 0.0, 0.015);
  EXPECT_NEAR(std::sqrt(squared), 0.1, 0.01);
}

TEST(PlaceSensors, ABeaconTwiceInAWorldIsRefused) {
  const std::string world =
      "room: {size: [5, 5]}\nlandmarks: []\ndrive: {start: {x: 1, y: 1, yaw_deg: 0}}\n"
      "gyro: {base_from_imu: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}}\n"
      "sensor: {base_from_optical: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}}\n"
      "beacons: {rate: 1, places: [{id: 2, x: 0, y: 9, z: 2}, {id: 2, x: 4, y: 0, z: 2}]}\n";
  EXPECT_EQ(testing::message_of<WorldFileError>([&] { parse_world(world, "w.yaml"); }),
            "w.yaml: beacons/places[1]/id: '2' given, allowed: a number that no other beacon has");
}

}  // namespace
}  // namespace kinect_ekf_slam
