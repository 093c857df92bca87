#include "kinect_ekf_slam/models/motion.h"

#include <gtest/gtest.h>

#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/body_velocity.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::PoseNear;
using testing::velocity;

template <class SpaceType>
class MotionNoise : public ::testing::Test {
 protected:
  /// Drives, and turns about an axis that leans in space; the gyro measures the roll, the wheels the rest.
  static BodyVelocity leaning(double forward, double turn) {
    BodyVelocity velocity;
    velocity.linear.x() = forward;
    velocity.angular = turn * Eigen::Vector3d(0.6, -0.5, 1.0);
    velocity.turned_by_gyro = {true, false, false};
    return velocity;
  }
  /// Covariance of a sequence of equal steps, in the axes of the last pose.
  static auto covariance_of_steps(const BodyVelocity& v, double time, int steps,
                                  const MotionOptions& options) {
    using PoseMatrix = typename SpaceType::PoseMatrix;
    PoseMatrix covariance = PoseMatrix::Zero();
    for (int i = 0; i < steps; ++i) {
      const MotionStep<SpaceType> step = motion_step<SpaceType>(v, time / steps, options);
      const PoseMatrix jacobian = step.delta.inverse().adjoint();
      covariance = jacobian * covariance * jacobian.transpose() + step.covariance;
    }
    return covariance;
  }
  static MotionOptions options(MotionOptions::Noise noise) {
    MotionOptions options;
    options.noise = noise;
    return options;
  }
};
TYPED_TEST_SUITE(MotionNoise, testing::Spaces, testing::SpaceNames);

TEST(Motion, FollowsTheArcExactly) {
  const double radius = 0.5;
  const auto step = motion_step<Planar>(velocity(radius * 0.8, 0.8), 1.25, {});
  EXPECT_TRUE(PoseNear(step.delta, Se2(radius * std::sin(1.0), radius * (1.0 - std::cos(1.0)), 1.0), 1e-12));
}

TEST(Motion, FollowsTheScrewExactly) {
  const double radius = 0.5;
  BodyVelocity climbing;  // drives along x while it pitches its nose up: half a loop
  climbing.linear.x() = radius * 0.8;
  climbing.angular.y() = -0.8;
  const auto step = motion_step<Spatial>(climbing, kPi / 0.8, {});
  EXPECT_TRUE(MatrixNear(step.delta.translation(), Eigen::Vector3d(0.0, 0.0, 2.0 * radius), 1e-12));
  EXPECT_TRUE(MatrixNear(step.delta.rotation() * Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX(), 1e-12));
}

TYPED_TEST(MotionNoise, ProportionalDoesNotDependOnTheStep) {
  const MotionOptions options = this->options(MotionOptions::Noise::kProportional);
  for (const auto& v : {this->leaning(0.2, 0.0), this->leaning(0.2, 0.9), this->leaning(0.0, 1.0)}) {
    const auto whole = this->covariance_of_steps(v, 0.1, 1, options);
    const auto halves = this->covariance_of_steps(v, 0.1, 2, options);
    EXPECT_TRUE(MatrixNear(whole, halves, 1e-6 * whole.norm()));
    if (v.linear.x() > 0.0) {  // on the spot it does not slip along the axis that it turns about
      EXPECT_GT(whole.determinant(), 0.0);
    }
  }
}

TYPED_TEST(MotionNoise, ReportDependsOnTheStep) {
  const MotionOptions options = this->options(MotionOptions::Noise::kReport);
  const auto whole = this->covariance_of_steps(velocity(0.2, 0.0), 0.1, 1, options);
  const auto halves = this->covariance_of_steps(velocity(0.2, 0.0), 0.1, 2, options);
  EXPECT_NEAR(halves(0, 0), 0.5 * whole(0, 0), 1e-12);
}

TYPED_TEST(MotionNoise, ReportIsTheReports) {
  constexpr int kHeading = TypeParam::kPoseDim - 1;
  const double dt = 0.1;
  const auto step =
      motion_step<TypeParam>(velocity(0.2, 0.0), dt, this->options(MotionOptions::Noise::kReport));
  EXPECT_NEAR(step.covariance(0, 0), 0.2 * 0.2 * dt * dt, 1e-12);  // |u| * 0.2 * dt^2
  EXPECT_NEAR(step.covariance(kHeading, kHeading), 0.2 * 0.2 * dt * dt, 1e-12);
}

TYPED_TEST(MotionNoise, ReportMapsByTheDerivativeOfTheMotion) {
  using Space = TypeParam;
  const double dt = 0.3;
  const BodyVelocity v = this->leaning(0.5, 0.9);
  const auto step = motion_step<Space>(v, dt, this->options(MotionOptions::Noise::kReport));
  const auto end_from_velocity = [&](const Eigen::VectorXd& noise) -> Eigen::VectorXd {
    const typename Space::PoseVector twist = Space::twist(v) + noise;
    return (step.delta.inverse() * Space::Pose::exp(twist * dt)).log();
  };
  const Eigen::MatrixXd W =
      testing::numerical_jacobian(end_from_velocity, Eigen::VectorXd::Zero(Space::kPoseDim));
  const double norm = Space::twist(v).norm();
  EXPECT_TRUE(MatrixNear(step.covariance, norm * 0.2 * W * W.transpose(), 1e-5));
}

TYPED_TEST(MotionNoise, ProportionalMatchesSampledRuns) {
  using Space = TypeParam;
  using PoseVector = typename Space::PoseVector;
  const MotionOptions options = this->options(MotionOptions::Noise::kProportional);
  const BodyVelocity v = this->leaning(0.3, 0.5);
  const double time = 1.0;
  const int pieces = 50;
  const double dt = time / pieces;
  const PoseVector twist = Space::twist(v);
  const double rate = twist.template tail<Space::kTurnDim>().norm();
  const double by_gyro = std::hypot(options.gyro_noise, options.gyro_noise_per_rate * rate);
  const double by_wheels =
      std::sqrt(std::pow(options.angular_noise, 2) + std::pow(options.angular_noise_per_rate * rate, 2) +
                std::pow(options.angular_noise_per_speed * 0.3, 2));
  PoseVector sigma = PoseVector::Constant(by_wheels);
  sigma.template head<Space::kPointDim>().setConstant(options.lateral_noise_per_speed * 0.3);
  sigma(0) = std::hypot(options.linear_noise, options.linear_noise_per_speed * 0.3);
  if (Space::kTurnDim == 3) sigma(Space::kPointDim) = by_gyro;  // the roll
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const auto expected = Space::Pose::exp(twist * time);
  typename Space::PoseMatrix sampled = Space::PoseMatrix::Zero();
  const int runs = 20000;
  for (int run = 0; run < runs; ++run) {
    typename Space::Pose pose;
    for (int i = 0; i < pieces; ++i) {
      const PoseVector noise = sigma.cwiseProduct(PoseVector::NullaryExpr([&] { return normal(random); }));
      pose = pose * Space::Pose::exp(twist * dt + noise * std::sqrt(dt));
    }
    const PoseVector error = (expected.inverse() * pose).log();
    sampled += error * error.transpose() / runs;
  }
  const auto predicted = motion_step<Space>(v, time, options).covariance;
  EXPECT_TRUE(MatrixNear(sampled, predicted, 0.03 * predicted.norm()));
}

TYPED_TEST(MotionNoise, NothingMovesNothingGrows) {
  const auto step = motion_step<TypeParam>(velocity(0.0, 0.0), 1.0, {});
  EXPECT_TRUE(PoseNear(step.delta, typename TypeParam::Pose(), 0.0));
  EXPECT_TRUE(MatrixNear(step.covariance, TypeParam::PoseMatrix::Zero(), 0.0));
}

}  // namespace
}  // namespace kinect_ekf_slam
