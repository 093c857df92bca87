#include "kinect_ekf_slam/ros/gradual_correction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

Eigen::Isometry3d pose(double x, double y, double yaw) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << x, y, 0.0;
  pose.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

constexpr TimeNs kStep = 20000000;  // 50 Hz

TEST(GradualCorrection, WithoutATimeConstantTheEstimateIsShown) {
  GradualCorrection correction(0.0);
  correction.follow(pose(1.0, 2.0, 0.3), pose(1.0, 2.0, 0.0), 0);
  const Eigen::Isometry3d map_from_base = pose(5.0, -1.0, -2.0);
  const Eigen::Isometry3d odom_from_base = pose(4.0, 0.5, 1.0);
  const Eigen::Isometry3d expected = map_from_base * odom_from_base.inverse();
  EXPECT_TRUE(
      MatrixNear(correction.follow(map_from_base, odom_from_base, kStep).matrix(), expected.matrix(), 1e-12));
}

TEST(GradualCorrection, TheFirstEstimateIsShownAsItIs) {
  GradualCorrection correction(1.0);
  EXPECT_TRUE(MatrixNear(correction.follow(pose(3.0, 0.0, 0.5), pose(0.0, 0.0, 0.0), 0).matrix(),
                         pose(3.0, 0.0, 0.5).matrix(), 1e-12));
}

TEST(GradualCorrection, AJumpIsSpreadAsAFirstOrderLag) {
  const double time_constant = 0.5;
  GradualCorrection correction(time_constant);
  const Eigen::Isometry3d odom_from_base = pose(0.0, 0.0, 0.0);
  correction.follow(pose(0.0, 0.0, 0.0), odom_from_base, 0);
  for (int step = 1; step <= 150; ++step) {
    const Eigen::Isometry3d shown = correction.follow(pose(0.4, 0.0, 0.2), odom_from_base, step * kStep);
    const double left = std::exp(-to_seconds(step * kStep) / time_constant);
    EXPECT_TRUE(MatrixNear(shown.matrix(), pose(0.4 * (1.0 - left), 0.0, 0.2 * (1.0 - left)).matrix(), 1e-9))
        << step;
  }
}

TEST(GradualCorrection, TheRateOfOdometryDoesNotMatter) {
  GradualCorrection often(1.0);
  GradualCorrection seldom(1.0);
  for (GradualCorrection* correction : {&often, &seldom}) correction->follow(pose(0, 0, 0), pose(0, 0, 0), 0);
  for (int step = 1; step < 50; ++step) often.follow(pose(1, 1, 1), pose(0, 0, 0), step * kStep);
  EXPECT_TRUE(MatrixNear(often.follow(pose(1, 1, 1), pose(0, 0, 0), 50 * kStep).matrix(),
                         seldom.follow(pose(1, 1, 1), pose(0, 0, 0), 50 * kStep).matrix(), 1e-9));
}

TEST(GradualCorrection, ARobotFarFromWhereItStartedIsMovedStraight) {
  GradualCorrection correction(1.0);
  const Eigen::Isometry3d odom_from_base = pose(100.0, 0.0, 0.0);
  correction.follow(pose(100.0, 0.0, 0.0), odom_from_base, 0);
  for (int step = 1; step <= 200; ++step) {  // its heading is 0.3 rad off, its place is right
    const Eigen::Isometry3d shown =
        correction.follow(pose(100.0, 0.0, 0.3), odom_from_base, step * kStep) * odom_from_base;
    EXPECT_LT((shown.translation() - Eigen::Vector3d(100.0, 0.0, 0.0)).norm(), 1e-9) << step;
  }
}

TEST(GradualCorrection, WhatTheWheelsSayIsNotDelayed) {
  GradualCorrection correction(1.0);
  correction.follow(pose(0.0, 0.0, 0.0), pose(0.0, 0.0, 0.0), 0);
  const Eigen::Isometry3d shown = correction.follow(pose(0.5, 0.0, 0.0), pose(0.5, 0.0, 0.0), kStep);
  EXPECT_TRUE(MatrixNear(shown.matrix(), pose(0.0, 0.0, 0.0).matrix(), 1e-12));
}

TEST(GradualCorrection, ARobotThatIsPutSomewhereIsThereAtOnce) {
  GradualCorrection correction(1.0);
  correction.follow(pose(0.0, 0.0, 0.0), pose(0.0, 0.0, 0.0), 0);
  correction.jump();
  EXPECT_TRUE(MatrixNear(correction.follow(pose(9.0, 9.0, 1.0), pose(0.0, 0.0, 0.0), kStep).matrix(),
                         pose(9.0, 9.0, 1.0).matrix(), 1e-12));
}

TEST(GradualCorrection, TimeThatStandsStillOrGoesBackMovesNothing) {
  GradualCorrection correction(1.0);
  correction.follow(pose(0.0, 0.0, 0.0), pose(0.0, 0.0, 0.0), kStep);
  for (const TimeNs stamp : {kStep, TimeNs{0}}) {
    EXPECT_TRUE(MatrixNear(correction.follow(pose(1.0, 0.0, 0.0), pose(0.0, 0.0, 0.0), stamp).matrix(),
                           pose(0.0, 0.0, 0.0).matrix(), 1e-12));
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
