#pragma once

#include <Eigen/Core>
#include <string>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// How uncertain a motion is (docs/theory.md, section 2).
struct MotionOptions {
  enum class Noise { kReport, kProportional };
  Noise noise = Noise::kProportional;

  /// `report`: covariance of the body velocities |u| * gain * I, per step, so it depends on the step's
  /// length.
  double report_gain = 0.2;

  /// `proportional`: standard deviations per square root of a second, so halving the step changes nothing.
  double linear_noise = 0.01;             ///< m/sqrt(s), while moving
  double linear_noise_per_speed = 0.10;   ///< (m/sqrt(s)) per m/s
  double lateral_noise_per_speed = 0.05;  ///< (m/sqrt(s)) per m/s: side slip
  double angular_noise = 0.03;            ///< rad/sqrt(s), while moving, turned by the wheels
  double angular_noise_per_rate = 0.10;   ///< (rad/sqrt(s)) per rad/s
  double angular_noise_per_speed = 0.05;  ///< (rad/sqrt(s)) per m/s
  double gyro_noise = 0.01;               ///< rad/sqrt(s), while moving, turned by the gyro
  double gyro_noise_per_rate = 0.03;      ///< (rad/sqrt(s)) per rad/s
};

/// One step of the robot: pose' = pose * delta * Exp(xi), xi ~ N(0, covariance).
template <class Space>
struct MotionStep {
  typename Space::Pose delta;
  typename Space::PoseMatrix covariance = Space::PoseMatrix::Zero();
};

/// Body velocities held over `dt` seconds, integrated exactly along the arc.
template <class Space>
MotionStep<Space> motion_step(const BodyVelocity& velocity, double dt, const MotionOptions& options);

}  // namespace kinect_ekf_slam
