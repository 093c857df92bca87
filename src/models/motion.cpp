#include "kinect_ekf_slam/models/motion.h"

#include <array>
#include <cmath>

namespace kinect_ekf_slam {
namespace {

constexpr int kFirstTurn = 3;  // of REP-103's x, y, z, roll, pitch, yaw

double squared(double value) { return value * value; }

/// Variance per second of each component of the twist: forward, sideways (and up), turning about each axis.
template <class Space>
typename Space::PoseVector proportional_density(const BodyVelocity& velocity, const MotionOptions& options) {
  const typename Space::PoseVector twist = Space::twist(velocity);
  const double speed = twist.template head<Space::kPointDim>().norm();
  const double rate = twist.template tail<Space::kTurnDim>().norm();
  typename Space::PoseVector density = Space::PoseVector::Zero();
  if (speed == 0.0 && rate == 0.0) return density;  // wheels that stand hold the robot
  density.template head<Space::kPointDim>().setConstant(squared(options.lateral_noise_per_speed * speed));
  density(0) = squared(options.linear_noise) + squared(options.linear_noise_per_speed * speed);
  const double by_gyro = squared(options.gyro_noise) + squared(options.gyro_noise_per_rate * rate);
  const double by_wheels = squared(options.angular_noise) + squared(options.angular_noise_per_rate * rate) +
                           squared(options.angular_noise_per_speed * speed);
  for (int i = Space::kPointDim; i < Space::kPoseDim; ++i) {
    density(i) = velocity.turned_by_gyro[Space::kPoseAxes[i] - kFirstTurn] ? by_gyro : by_wheels;
  }
  return density;
}

}  // namespace

template <class Space>
MotionStep<Space> motion_step(const BodyVelocity& velocity, double dt, const MotionOptions& options) {
  using Pose = typename Space::Pose;
  using PoseMatrix = typename Space::PoseMatrix;
  const typename Space::PoseVector twist = Space::twist(velocity);
  MotionStep<Space> step;
  step.delta = Pose::exp(twist * dt);

  // A disturbance at time s reaches the step's end through Ad(Exp(-twist (dt - s))): equation (2.4).
  // Two Gauss-Legendre nodes integrate the cubic terms along the arc exactly.
  const double offset = 0.5 / std::sqrt(3.0);
  std::array<PoseMatrix, 2> end_from_node;
  for (int node = 0; node < 2; ++node) {
    const double remaining = dt * (node == 0 ? 0.5 + offset : 0.5 - offset);
    end_from_node[node] = Pose::exp(-twist * remaining).adjoint();
  }
  if (options.noise == MotionOptions::Noise::kReport) {
    // The same disturbance all through the step: W = integral of Ad, equation (2.5).
    const PoseMatrix velocity_to_end = 0.5 * dt * (end_from_node[0] + end_from_node[1]);
    step.covariance = twist.norm() * options.report_gain * velocity_to_end * velocity_to_end.transpose();
  } else {
    // White noise: the integral of Ad q Ad^T, equation (2.6).
    const typename Space::PoseVector density = proportional_density<Space>(velocity, options);
    for (const PoseMatrix& jacobian : end_from_node) {
      step.covariance += 0.5 * dt * (jacobian * density.asDiagonal() * jacobian.transpose());
    }
  }
  return step;
}

template MotionStep<Planar> motion_step<Planar>(const BodyVelocity&, double, const MotionOptions&);
template MotionStep<Spatial> motion_step<Spatial>(const BodyVelocity&, double, const MotionOptions&);

}  // namespace kinect_ekf_slam
