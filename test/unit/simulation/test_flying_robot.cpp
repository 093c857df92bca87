/// What a robot that flies does that one on the floor cannot.
#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/simulator.h"
#include "test/support/matchers.h"
#include "test/unit/simulation/small_world.h"

namespace kinect_ekf_slam::testing {
namespace {

/// exact_world() with a robot in the air at its middle.
World exact_air() {
  World world = exact_world();
  world.room_size = {20.0, 20.0, 20.0};
  world.drive.world_from_start = Se3({10.0, 10.0, 10.0}, Eigen::Quaterniond::Identity());
  return world;
}

WorldLandmark ball(int id, const Eigen::Vector3d& from_start, double radius = 0.05) {
  return {id, "red", Eigen::Vector3d(10.0, 10.0, 10.0) + from_start, radius};
}

World exact_flight() {
  World world = exact_air();
  world.drive.waypoints_in_world = {{11.5, 10.0, 10.8}, {11.5, 11.5, 9.2}, {10.0, 10.0, 10.0}};
  return world;
}

TEST(FlyingRobot, ReachesItsWaypointsAndBanksOnTheWay) {
  Simulator simulator(exact_flight(), 1);
  Sample sample = simulator.next();
  double highest = 0.0;
  double lowest = 20.0;
  double steepest_roll = 0.0;
  while (!simulator.finished() && to_seconds(sample.stamp) < 100.0) {
    sample = simulator.next();
    highest = std::max(highest, sample.world_from_base.translation().z());
    lowest = std::min(lowest, sample.world_from_base.translation().z());
    steepest_roll = std::max(steepest_roll, std::abs(sample.world_from_base.linear()(2, 1)));
  }
  ASSERT_TRUE(simulator.finished());
  EXPECT_LT((sample.world_from_base.translation() - Eigen::Vector3d(10.0, 10.0, 10.0)).norm(), 0.1);
  EXPECT_GT(highest, 10.6);
  EXPECT_LT(lowest, 9.4);
  EXPECT_GT(steepest_roll, std::sin(radians(5.0)));
}

TEST(FlyingRobot, WithoutErrorsOdometryAndGyroAreTheTruth) {
  const World world = exact_flight();
  const Eigen::Isometry3d world_from_start = world.drive.world_from_start.to_3d();
  for (const Sample& sample : run(world, 1, 30.0)) {
    if (!sample.odometry) continue;
    const Eigen::Isometry3d world_from_base = world_from_start * sample.odometry->odom_from_base;
    ASSERT_TRUE(MatrixNear(world_from_base.matrix(), sample.world_from_base.matrix(), 1e-6));
  }
  Se3 integrated;
  TimeNs since = 0;
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  for (const Sample& sample : run(world, 1, 30.0)) {
    const Eigen::Vector3d turn = rate * to_seconds(sample.stamp - since);
    integrated = integrated * Se3({0.0, 0.0, 0.0}, rotation_exp(turn));
    since = sample.stamp;
    if (sample.gyro_rate_in_imu) rate = *sample.gyro_rate_in_imu;
    EXPECT_LT(
        rotation_log(integrated.attitude().conjugate() * Eigen::Quaterniond(sample.world_from_base.linear()))
            .norm(),
        0.02)
        << "all three rates";
  }
}

TEST(FlyingRobot, StopsBeforeCeilingAndBalls) {
  World world = exact_air();
  world.room_size.z() = 11.0;
  world.landmarks = {ball(1, {0.5, 0.0, 0.3}, 0.1)};
  Simulator simulator(world, 1);
  BodyVelocity command;
  command.linear.x() = 0.2;
  simulator.set_command(command);
  Sample sample;
  while (to_seconds(sample.stamp) < 20.0) sample = simulator.next();
  EXPECT_GT(sample.world_from_base.translation().x(), 12.0) << "it passes below the ball";
  command.linear.x() = 0.0;
  command.angular.y() = -0.5;  // the nose up
  simulator.set_command(command);
  while (sample.world_from_base.linear()(2, 0) < 0.99) sample = simulator.next();
  command.angular.setZero();
  command.linear.x() = 0.2;
  simulator.set_command(command);
  const double until = to_seconds(sample.stamp) + 20.0;
  while (to_seconds(sample.stamp) < until) sample = simulator.next();
  EXPECT_NEAR(sample.world_from_base.translation().z(), 11.0 - world.drive.robot_radius, 0.02);
}

TEST(FlyingRobot, SeesAsHighAndAsWideAsAKinect) {
  World world = exact_air();
  const double wide = 1.5 * std::tan(radians(28.5));
  const double high = 1.5 * std::tan(radians(21.5));
  int id = 0;
  for (const auto& [left, up, visible] : {std::tuple(0.0, 0.95, true),
                                          {0.0, 1.05, false},
                                          {0.0, -0.95, true},
                                          {0.0, -1.05, false},
                                          {0.95, 0.95, true},
                                          {1.05, 0.0, false}}) {
    world.landmarks = {ball(++id, {1.5, left * wide, up * high})};
    EXPECT_EQ(pictures(world, 1, 1).front().size(), visible ? 1U : 0U) << left << ", " << up;
  }
}

TEST(FlyingRobot, ABallHidesWhatIsBehindItAndNotWhatIsAbove) {
  World world = exact_air();
  world.landmarks = {ball(1, {1.0, 0.0, 0.0}, 0.1), ball(2, {2.0, 0.1, 0.0}), ball(3, {2.0, 0.0, 0.4})};
  const auto sightings = pictures(world, 1, 1).front();
  ASSERT_EQ(sightings.size(), 2U);
  EXPECT_EQ(sightings[0].id, 1);
  EXPECT_EQ(sightings[1].id, 3);
}

}  // namespace
}  // namespace kinect_ekf_slam::testing
