#include "kinect_ekf_slam/models/input_conditioner.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

/// Each component within the limit: a roll must not take from the yaw.
Eigen::Vector3d clamp(const Eigen::Vector3d& rates, double limit) {
  return rates.cwiseMax(-limit).cwiseMin(limit);
}

/// The vector, shortened to `limit` if it is longer.
Eigen::Vector3d saturate(const Eigen::Vector3d& vector, double limit) {
  constexpr double kBeyondBelief = 1e100;  // m/s; the square of a larger one overflows
  const Eigen::Vector3d sane = clamp(vector, kBeyondBelief);
  const double norm = sane.norm();
  return norm > limit ? Eigen::Vector3d(sane * (limit / norm)) : sane;
}

}  // namespace

void InputConditioner::add_odometry(TimeNs stamp, const BodyVelocity& odometry) {
  if (odometry_) odometry_period_ = to_seconds(stamp - odometry_->stamp);
  BodyVelocity calibrated;
  calibrated.linear = saturate(options_.linear_scale * odometry.linear, options_.max_linear_speed);
  calibrated.angular = clamp(options_.angular_scale * odometry.angular, options_.max_angular_speed);
  odometry_ = {stamp, calibrated};
  if (!stands()) {
    standing_since_.reset();
  } else if (!standing_since_) {
    standing_since_ = stamp;
  }
}

void InputConditioner::add_gyro(TimeNs stamp, const Eigen::Vector3d& rate) {
  const double dt = gyro_ ? std::min(to_seconds(stamp - gyro_->stamp), options_.max_gyro_age) : 0.0;
  gyro_ = {stamp, rate};
  if (!options_.estimate_gyro_bias || !standing_since_ || hold_time(stamp) <= 0.0) return;
  if (to_seconds(stamp - *standing_since_) < options_.standing_time) return;
  if (rate.norm() > options_.gyro_bias_limit) return;
  // A running mean at first, an exponential one once `gyro_bias_time` has been seen.
  ++bias_samples_;
  const double weight = std::max(1.0 / bias_samples_, std::min(1.0, dt / options_.gyro_bias_time));
  gyro_bias_ += weight * (rate - gyro_bias_);
}

bool InputConditioner::stands() const {
  return odometry_ && odometry_->value.linear.norm() <= options_.standing_speed &&
         odometry_->value.angular.norm() <= options_.standing_speed;
}

double InputConditioner::turn_rate(double odometry_rate, double gyro_rate) const {
  const double threshold =
      odometry_period_ > 0.0 ? radians(options_.heading_threshold_deg) / odometry_period_ : 0.0;
  const bool differ = std::abs(odometry_rate - gyro_rate) > threshold;
  switch (options_.heading_source) {
    case HeadingSource::kOdometry:
      return odometry_rate;
    case HeadingSource::kImu:
      return gyro_rate;
    case HeadingSource::kGyrodometry:
      return differ ? gyro_rate : odometry_rate;
    case HeadingSource::kGyrodometryReport:
      // As the report means it: if, else if, else. Its listing falls through to the odometry always.
      if (differ) return gyro_rate;
      if (last_odometry().linear.norm() > options_.standing_speed) return gyro_rate;
      return odometry_rate;
  }
  return odometry_rate;
}

double InputConditioner::hold_time(TimeNs stamp) const {
  return odometry_ ? options_.max_odometry_gap - to_seconds(stamp - odometry_->stamp) : 0.0;
}

BodyVelocity InputConditioner::velocity(TimeNs stamp) const {
  BodyVelocity velocity = last_odometry();
  if (gyro_ && std::abs(to_seconds(stamp - gyro_->stamp)) <= options_.max_gyro_age) {
    const Eigen::Vector3d gyro_rate = clamp(gyro_->value - gyro_bias_, options_.max_angular_speed);
    for (int axis = 0; axis < 3; ++axis) {
      velocity.angular(axis) = turn_rate(velocity.angular(axis), gyro_rate(axis));
      velocity.turned_by_gyro[axis] = velocity.angular(axis) == gyro_rate(axis);
    }
  }
  return velocity;
}

}  // namespace kinect_ekf_slam
