#include "kinect_ekf_slam/models/motion.h"

#include <gtest/gtest.h>

#include <random>

#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::PoseNear;

BodyVelocity velocity(double forward, double turn) {
  BodyVelocity velocity;
  velocity.linear.x() = forward;
  velocity.angular.z() = turn;
  return velocity;
}

/// Covariance of a straight sequence of steps, in the axes of the last pose.
Eigen::Matrix3d covariance_of_steps(const BodyVelocity& v, double time, int steps,
                                    const MotionOptions& options) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int i = 0; i < steps; ++i) {
    const MotionStep<Planar> step = motion_step<Planar>(v, time / steps, options);
    const Eigen::Matrix3d jacobian = step.delta.inverse().adjoint();
    covariance = jacobian * covariance * jacobian.transpose() + step.covariance;
  }
  return covariance;
}

TEST(Motion, FollowsTheArcExactly) {
  const double radius = 0.5;
  const auto step = motion_step<Planar>(velocity(radius * 0.8, 0.8), 1.25, {});
  EXPECT_TRUE(PoseNear(step.delta, Se2(radius * std::sin(1.0), radius * (1.0 - std::cos(1.0)), 1.0), 1e-12));
}

TEST(Motion, ProportionalNoiseDoesNotDependOnTheStep) {
  MotionOptions options;
  options.noise = MotionOptions::Noise::kProportional;
  for (const auto& v : {velocity(0.2, 0.0), velocity(0.2, 0.9), velocity(0.0, 1.0)}) {
    const Eigen::Matrix3d whole = covariance_of_steps(v, 0.1, 1, options);
    const Eigen::Matrix3d halves = covariance_of_steps(v, 0.1, 2, options);
    EXPECT_TRUE(MatrixNear(whole, halves, 1e-6 * whole.norm()));
    EXPECT_GT(whole.determinant(), 0.0);
  }
}

TEST(Motion, ReportNoiseDependsOnTheStep) {
  MotionOptions options;
  options.noise = MotionOptions::Noise::kReport;
  const Eigen::Matrix3d whole = covariance_of_steps(velocity(0.2, 0.0), 0.1, 1, options);
  const Eigen::Matrix3d halves = covariance_of_steps(velocity(0.2, 0.0), 0.1, 2, options);
  EXPECT_NEAR(halves(0, 0), 0.5 * whole(0, 0), 1e-12);
}

TEST(Motion, ReportNoiseIsTheReports) {
  MotionOptions options;
  options.noise = MotionOptions::Noise::kReport;
  const double dt = 0.1;
  const auto step = motion_step<Planar>(velocity(0.2, 0.0), dt, options);
  EXPECT_NEAR(step.covariance(0, 0), 0.2 * 0.2 * dt * dt, 1e-12);  // |u| * 0.2 * dt^2
  EXPECT_NEAR(step.covariance(2, 2), 0.2 * 0.2 * dt * dt, 1e-12);
}

TEST(Motion, ReportNoiseMapsByTheDerivativeOfTheMotion) {
  MotionOptions options;
  options.noise = MotionOptions::Noise::kReport;
  const double dt = 0.3;
  const BodyVelocity v = velocity(0.5, 0.9);
  const auto step = motion_step<Planar>(v, dt, options);
  const auto end_from_velocity = [&](const Eigen::VectorXd& noise) -> Eigen::VectorXd {
    const Eigen::Vector3d twist = Planar::twist(v) + noise;
    return (step.delta.inverse() * Se2::exp(twist * dt)).log();
  };
  const Eigen::MatrixXd W = testing::numerical_jacobian(end_from_velocity, Eigen::VectorXd::Zero(3));
  const double norm = Planar::twist(v).norm();
  EXPECT_TRUE(MatrixNear(step.covariance, norm * 0.2 * W * W.transpose(), 1e-5));
}

TEST(Motion, ProportionalNoiseMatchesSampledRuns) {
  MotionOptions options;
  options.noise = MotionOptions::Noise::kProportional;
  const BodyVelocity v = velocity(0.3, 0.5);
  const double time = 1.0;
  const int pieces = 50;
  const double dt = time / pieces;
  const double forward = std::hypot(options.linear_noise, options.linear_noise_per_speed * 0.3);
  const double sideways = options.lateral_noise_per_speed * 0.3;
  const double turn =
      std::sqrt(std::pow(options.angular_noise, 2) + std::pow(options.angular_noise_per_rate * 0.5, 2) +
                std::pow(options.angular_noise_per_speed * 0.3, 2));
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const Se2 expected = Se2::exp(Planar::twist(v) * time);
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  const int runs = 20000;
  for (int run = 0; run < runs; ++run) {
    Se2 pose;
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector3d noise(forward * normal(random), sideways * normal(random), turn * normal(random));
      pose = pose * Se2::exp(Planar::twist(v) * dt + noise * std::sqrt(dt));
    }
    const Eigen::Vector3d error = (expected.inverse() * pose).log();
    sampled += error * error.transpose() / runs;
  }
  const Eigen::Matrix3d predicted = motion_step<Planar>(v, time, options).covariance;
  EXPECT_TRUE(MatrixNear(sampled, predicted, 0.03 * predicted.norm()));
}

TEST(Motion, NothingMovesNothingGrows) {
  const auto step = motion_step<Planar>(velocity(0.0, 0.0), 1.0, {});
  EXPECT_TRUE(PoseNear(step.delta, Se2(), 0.0));
  EXPECT_TRUE(MatrixNear(step.covariance, Eigen::Matrix3d::Zero(), 0.0));
}

}  // namespace
}  // namespace kinect_ekf_slam
