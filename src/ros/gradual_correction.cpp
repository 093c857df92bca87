#include "kinect_ekf_slam/ros/gradual_correction.h"

#include <algorithm>
#include <cmath>

namespace kinect_ekf_slam {

Eigen::Isometry3d GradualCorrection::follow(const Eigen::Isometry3d& map_from_base,
                                            const Eigen::Isometry3d& odom_from_base, TimeNs stamp) {
  Eigen::Isometry3d shown_from_base = map_from_base;
  if (shown_ && time_constant_ > 0.0) {
    const double passed = std::max(to_seconds(stamp - shown_->stamp), 0.0);
    const double share = -std::expm1(-passed / time_constant_);
    const Eigen::Isometry3d before = shown_->map_from_odom * odom_from_base;
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(before.rotation()).slerp(share, Eigen::Quaterniond(map_from_base.rotation()));
    shown_from_base.linear() = turned.normalized().toRotationMatrix();
    shown_from_base.translation() =
        before.translation() + share * (map_from_base.translation() - before.translation());
  }
  shown_ = Shown{shown_from_base * odom_from_base.inverse(), stamp};
  return shown_->map_from_odom;
}

}  // namespace kinect_ekf_slam
