#include <gtest/gtest.h>

#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/simulator.h"
#include "test/support/matchers.h"
#include "test/unit/simulation/small_world.h"

namespace kinect_ekf_slam::testing {
namespace {

World noisy_world() {
  World world;
  world.room_size = {20.0, 20.0, 0.0};
  world.drive.world_from_start = Se2(10.0, 10.0, 0.3);
  world.drive.waypoints_in_world = {{12.0, 11.0, 0.0}, {9.0, 12.0, 0.0}};
  world.landmarks = {cylinder(1, 2.0, 0.4), cylinder(2, 2.2, -0.4), cylinder(3, -1.0, 2.0)};
  world.sensor = exact_world().sensor;
  world.sensor.noise_scale = 1.0;
  world.sensor.miss_rate = 0.1;
  world.sensor.false_per_minute = 60.0;
  return world;
}

bool same(const Sample& a, const Sample& b) {
  if (a.stamp != b.stamp || a.odometry.has_value() != b.odometry.has_value() ||
      a.gyro_rate_in_imu != b.gyro_rate_in_imu || a.sightings.has_value() != b.sightings.has_value()) {
    return false;
  }
  if (a.odometry && (a.odometry->odom_from_base.matrix() != b.odometry->odom_from_base.matrix() ||
                     a.odometry->velocity.angular != b.odometry->velocity.angular)) {
    return false;
  }
  if (!a.sightings) return true;
  if (a.sightings->size() != b.sightings->size()) return false;
  for (std::size_t i = 0; i < a.sightings->size(); ++i) {
    if ((*a.sightings)[i].position_in_optical != (*b.sightings)[i].position_in_optical) return false;
  }
  return true;
}

double standard_deviation(const std::vector<double>& values) {
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(values.size());
  return std::sqrt(squares / count - sum * sum / (count * count));
}

TEST(Simulator, SameSeedSameSamples) {
  const auto first = run(noisy_world(), 7, 20.0);
  const auto second = run(noisy_world(), 7, 20.0);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) ASSERT_TRUE(same(first[i], second[i])) << "sample " << i;
}

TEST(Simulator, DifferentSeedsDiffer) {
  const auto first = run(noisy_world(), 7, 1.0);
  const auto second = run(noisy_world(), 8, 1.0);
  EXPECT_NE(first.front().gyro_rate_in_imu, second.front().gyro_rate_in_imu);
  EXPECT_FALSE(same(first.front(), second.front()));
}

TEST(Simulator, ADetectorSettingLeavesWheelsAndGyroAsTheyWere) {
  World other = noisy_world();
  other.sensor.miss_rate = 0.5;
  other.sensor.rate = 5.0;
  Simulator a(noisy_world(), 3);
  Simulator b(other, 3);
  for (int i = 0; i < 300; ++i) {
    Sample of_a = a.next();
    Sample of_b = b.next();
    while (!of_a.odometry) of_a = a.next();
    while (!of_b.odometry) of_b = b.next();
    ASSERT_EQ(of_a.odometry->odom_from_base.translation(), of_b.odometry->odom_from_base.translation());
  }
}

TEST(Simulator, SensorsKeepTheirRatesAndTheOrderOfTime) {
  const auto samples = run(noisy_world(), 1, 9.999);
  int odometry = 0;
  int gyro = 0;
  int pictures_taken = 0;
  TimeNs last = -1;
  for (const Sample& sample : samples) {
    EXPECT_GT(sample.stamp, last);
    last = sample.stamp;
    odometry += sample.odometry.has_value() ? 1 : 0;
    gyro += sample.gyro_rate_in_imu.has_value() ? 1 : 0;
    pictures_taken += sample.sightings.has_value() ? 1 : 0;
  }
  EXPECT_EQ(odometry, 300);
  EXPECT_EQ(gyro, 1000);
  EXPECT_EQ(pictures_taken, 100);
}

TEST(Simulator, WithoutErrorsTheOdometryIsTheTruth) {
  World world = exact_world();
  world.drive.waypoints_in_world = {{11.0, 11.0, 0.0}, {9.0, 10.5, 0.0}, {10.0, 10.0, 0.0}};
  double path = 0.0;
  const Eigen::Isometry3d world_from_start = world.drive.world_from_start.to_3d();
  Eigen::Isometry3d last = world_from_start;
  for (const Sample& sample : run(world, 1, 40.0)) {
    if (!sample.odometry) continue;
    const Eigen::Isometry3d world_from_base = world_from_start * sample.odometry->odom_from_base;
    ASSERT_TRUE(MatrixNear(world_from_base.matrix(), sample.world_from_base.matrix(), 1e-9))
        << to_seconds(sample.stamp);
    const Se2 step = Planar::pose_from_3d(last.inverse() * sample.world_from_base);
    const Eigen::Vector3d twist = step.log() * world.wheels.rate;
    if (sample.stamp > 0) {
      ASSERT_NEAR(twist.x(), sample.odometry->velocity.linear.x(), 1e-6);
      ASSERT_NEAR(twist.y(), 0.0, 1e-6) << "a differential drive does not go sideways";
      ASSERT_NEAR(twist.z(), sample.odometry->velocity.angular.z(), 1e-6);
    }
    path += step.translation().norm();
    last = sample.world_from_base;
  }
  EXPECT_GT(path, 4.0);
}

TEST(Simulator, WheelScaleErrorsDriftAsExpected) {
  World world = exact_world();
  world.wheels.scale_sigma = 0.01;
  world.drive.waypoints_in_world = {{12.0, 10.0, 0.0}};
  constexpr int kSeeds = 400;
  std::vector<double> length_errors;
  std::vector<double> headings;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Simulator simulator(world, static_cast<std::uint64_t>(seed));
    Sample sample = simulator.next();
    while (!simulator.finished()) sample = simulator.next();
    while (!sample.odometry) sample = simulator.next();
    const double length = (sample.world_from_base.translation() - Eigen::Vector3d(10.0, 10.0, 0.0)).norm();
    length_errors.push_back(sample.odometry->odom_from_base.translation().norm() / length - 1.0);
    headings.push_back(Planar::pose_from_3d(sample.odometry->odom_from_base).angle() / length);
  }
  // The mean of two wheels, and their difference over the distance between them; 15 % is four sigma of 400
  // draws.
  const double expected_length = world.wheels.scale_sigma / std::sqrt(2.0);
  const double expected_heading = world.wheels.scale_sigma * std::sqrt(2.0) / world.wheels.separation;
  EXPECT_NEAR(standard_deviation(length_errors), expected_length, 0.15 * expected_length);
  EXPECT_NEAR(standard_deviation(headings), expected_heading, 0.15 * expected_heading);
}

TEST(Simulator, WheelNoiseGrowsWithTheRootOfTheWay) {
  World world = exact_world();
  world.wheels.noise = 0.01;
  world.drive.waypoints_in_world = {{12.0, 10.0, 0.0}};
  std::vector<double> headings;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Simulator simulator(world, seed);
    Sample sample = simulator.next();
    while (!simulator.finished() || !sample.odometry) sample = simulator.next();
    headings.push_back(Planar::pose_from_3d(sample.odometry->odom_from_base).angle());
  }
  const double expected =
      world.wheels.noise * std::sqrt(2.0 * 2.0) / world.wheels.separation;  // 2 m, two wheels
  EXPECT_NEAR(standard_deviation(headings), expected, 0.15 * expected);
}

TEST(Simulator, AStandingRobotsWheelsReportRestAndItsGyroTheBias) {
  World world = noisy_world();
  world.drive.waypoints_in_world.clear();
  world.gyro.bias_walk = 0.0;
  std::vector<double> biases;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const Sample& sample : run(world, seed, 1.0)) {
      if (sample.odometry) {
        ASSERT_TRUE(sample.odometry->velocity.linear.isZero(0.0));
      }
      if (!sample.gyro_rate_in_imu) continue;
      sum += *sample.gyro_rate_in_imu;
      ++count;
    }
    biases.push_back(sum.z() / count);
  }
  EXPECT_NEAR(standard_deviation(biases), world.gyro.bias_sigma, 0.2 * world.gyro.bias_sigma);
}

TEST(Simulator, AnImuOnItsSideTurnsAboutItsOwnAxes) {
  World world = exact_world();
  world.gyro.base_from_imu.linear() =
      Eigen::AngleAxisd(radians(90.0), Eigen::Vector3d::UnitX()).toRotationMatrix();  // its y is the base's z
  Simulator simulator(world, 1);
  BodyVelocity turn;
  turn.angular.z() = 0.5;
  simulator.set_command(turn);
  Sample sample;
  while (to_seconds(sample.stamp) < 2.0 || !sample.gyro_rate_in_imu) sample = simulator.next();
  EXPECT_TRUE(MatrixNear(*sample.gyro_rate_in_imu, Eigen::Vector3d(0.0, 0.5, 0.0), 1e-9));
}

TEST(Simulator, KeepsTheLimitsOfSpeedAndAcceleration) {
  World world = exact_world();
  world.drive.standing_time = 2.0;
  world.drive.waypoints_in_world = {{9.0, 11.0, 0.0}, {11.0, 11.0, 0.0}};
  const double period = 1.0 / world.wheels.rate;
  BodyVelocity last;
  for (const Sample& sample : run(world, 1, 60.0)) {
    if (!sample.odometry) continue;
    const BodyVelocity& velocity = sample.odometry->velocity;
    if (to_seconds(sample.stamp) <= world.drive.standing_time) {
      EXPECT_TRUE(velocity.linear.isZero(0.0));
    }
    EXPECT_LE(std::abs(velocity.linear.x()), world.drive.max_speed + 1e-6);
    EXPECT_LE(std::abs(velocity.angular.z()), world.drive.max_turn_rate + 1e-6);
    EXPECT_LE(std::abs(velocity.linear.x() - last.linear.x()), world.drive.max_acceleration * period + 1e-6);
    EXPECT_LE(std::abs(velocity.angular.z() - last.angular.z()),
              world.drive.max_turn_acceleration * period + 1e-6);
    last = velocity;
  }
}

TEST(Simulator, WaypointsEndAtTheLastOne) {
  World world = exact_world();
  world.drive.waypoints_in_world = {{11.0, 10.0, 0.0}, {11.0, 11.0, 0.0}, {10.0, 10.0, 0.0}};
  world.drive.loops = 2;
  Simulator simulator(world, 1);
  Sample sample = simulator.next();
  while (!simulator.finished() && to_seconds(sample.stamp) < 200.0) sample = simulator.next();
  ASSERT_TRUE(simulator.finished());
  EXPECT_LT((sample.world_from_base.translation() - Eigen::Vector3d(10.0, 10.0, 0.0)).norm(), 0.1);
}

TEST(Simulator, WallsAndCylindersStopACommandedRobot) {
  World world = exact_world();
  world.room_size = {12.0, 20.0, 0.0};
  world.landmarks = {cylinder(1, -1.0, 0.0)};
  for (const double speed : {0.2, -0.2}) {
    Simulator simulator(world, 1);
    BodyVelocity command;
    command.linear.x() = speed;
    simulator.set_command(command);
    Sample sample;
    while (to_seconds(sample.stamp) < 30.0) sample = simulator.next();
    const double distance = speed > 0.0 ? 12.0 - sample.world_from_base.translation().x()
                                        : sample.world_from_base.translation().x() - 9.05;
    EXPECT_GE(distance, world.drive.robot_radius - 1e-6);  // stamps are whole nanoseconds
    EXPECT_LT(distance, world.drive.robot_radius + 0.02);
    EXPECT_FALSE(simulator.finished());
  }
}

}  // namespace
}  // namespace kinect_ekf_slam::testing
