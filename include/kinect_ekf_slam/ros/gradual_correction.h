#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// Spreads corrections of `map -> odom` over time, for controllers that dislike jumps: what is shown lags
/// behind what is estimated by a first-order filter, 63 % of a correction after the time constant, 95 % after
/// three.
class GradualCorrection {
 public:
  /// s; 0: what is shown is what is estimated.
  explicit GradualCorrection(double time_constant) : time_constant_(time_constant) {}

  /// `map_from_odom` as it is to be shown at `stamp`. Between what was shown and what is estimated the robot
  /// is moved on a straight line, wherever the origin of its odometry lies.
  Eigen::Isometry3d follow(const Eigen::Isometry3d& map_from_base, const Eigen::Isometry3d& odom_from_base,
                           TimeNs stamp);

  /// The next estimate is shown as it is: the robot was put somewhere, that is no correction.
  void jump() { shown_.reset(); }

 private:
  struct Shown {
    Eigen::Isometry3d map_from_odom;
    TimeNs stamp;
  };
  double time_constant_;
  std::optional<Shown> shown_;
};

}  // namespace kinect_ekf_slam
