#pragma once

#include <Eigen/Core>
#include <optional>

#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// Which sensor is believed for the heading, and in space for roll and pitch alike (docs/theory.md, section
/// 1).
enum class HeadingSource { kGyrodometryReport, kGyrodometry, kOdometry, kImu };

struct InputOptions {
  double max_linear_speed = 0.22;  ///< m/s; beyond it the odometry is clamped
  double max_angular_speed = 1.1;  ///< rad/s
  double linear_scale = 1.0;       ///< true speed over the odometry's
  double angular_scale = 1.0;      ///< true turn rate over the odometry's
  HeadingSource heading_source = HeadingSource::kGyrodometryReport;
  double heading_threshold_deg =
      0.03;                       ///< deg a step: the threshold on the rates' difference is this over dt
  double max_gyro_age = 0.07;     ///< s; an older gyro rate is not used
  double max_odometry_gap = 1.0;  ///< s; a velocity is held no longer than this

  bool estimate_gyro_bias = true;
  double standing_speed = 1e-3;  ///< m/s and rad/s: slower odometry means that the robot stands
  double standing_time = 0.5;    ///< s that it has stood before its gyro's bias is learnt
  double gyro_bias_limit = 0.1;  ///< rad/s; a standing robot whose gyro turns faster is being pushed
  double gyro_bias_time = 10.0;  ///< s; time constant of the bias estimate
};

/// Turns raw odometry and gyro rates into the one velocity that moves the estimate.
///
/// Each rate holds from its stamp until the next one. Cheap to copy: a copy looks ahead without changing the
/// original.
class InputConditioner {
 public:
  explicit InputConditioner(const InputOptions& options) : options_(options) {}

  void add_odometry(TimeNs stamp, const BodyVelocity& odometry);
  /// `rate` in the axes of the base, rad/s.
  void add_gyro(TimeNs stamp, const Eigen::Vector3d& rate);

  /// Velocity of the base at `stamp`: the last odometry, its rate about each axis chosen between odometry and
  /// gyro.
  BodyVelocity velocity(TimeNs stamp) const;

  /// s from `stamp` for which the last odometry still holds; zero or less: it does not.
  double hold_time(TimeNs stamp) const;

  /// The last velocity known, however old; zero before the first.
  BodyVelocity last_odometry() const { return odometry_ ? odometry_->value : BodyVelocity{}; }

  /// rad/s about the base's axes, zero until the robot has stood with its gyro running.
  const Eigen::Vector3d& gyro_bias() const { return gyro_bias_; }

  void set_options(const InputOptions& options) { options_ = options; }

 private:
  template <class Value>
  struct Stamped {
    TimeNs stamp;
    Value value;
  };

  bool stands() const;
  double turn_rate(double odometry_rate, double gyro_rate) const;

  InputOptions options_;
  std::optional<Stamped<BodyVelocity>> odometry_;
  std::optional<Stamped<Eigen::Vector3d>> gyro_;  ///< bias not taken off
  double odometry_period_ = 0.0;                  ///< s
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  int bias_samples_ = 0;
  std::optional<TimeNs> standing_since_;
};

}  // namespace kinect_ekf_slam
