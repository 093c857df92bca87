#include "kinect_ekf_slam/simulation/waypoint_driver.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kPassingDistance = 0.15;      // m at which a waypoint counts as reached
constexpr double kStoppingDistance = 0.03;     // m, for the last one
constexpr double kTurningGain = 2.0;           // 1/s
constexpr double kTurnOnSpot = radians(60.0);  // heading error from which the robot does not advance
constexpr double kBank = 0.5;                  // rad of roll per rad/s of turning

}  // namespace

BodyVelocity WaypointDriver::command(TimeNs now, const Eigen::Isometry3d& world_from_base) {
  BodyVelocity velocity;
  if (to_seconds(now) < options_.standing_time || done()) return velocity;
  const auto& waypoints = options_.waypoints_in_world;
  const bool last = next_ + 1 == waypoint_count();
  const Eigen::Vector3d target_in_base = world_from_base.inverse() * waypoints[next_ % waypoints.size()];
  const double distance = target_in_base.norm();
  if (distance < (last ? kStoppingDistance : kPassingDistance)) {
    ++next_;
    return command(now, world_from_base);
  }
  const double heading_error = std::atan2(target_in_base.y(), target_in_base.x());
  const double elevation = std::atan2(target_in_base.z(), target_in_base.head<2>().norm());
  const double straightness = std::max(0.0, 1.0 - std::hypot(heading_error, elevation) / kTurnOnSpot);
  velocity.linear.x() = options_.max_speed * straightness;
  if (last) {  // half the braking distance in reserve
    velocity.linear.x() = std::min(velocity.linear.x(), std::sqrt(options_.max_acceleration * distance));
  }
  velocity.angular.z() =
      std::clamp(kTurningGain * heading_error, -options_.max_turn_rate, options_.max_turn_rate);
  if (options_.world_from_start.is_spatial()) {
    const Eigen::Vector3d up_in_base = world_from_base.linear().row(2);
    const double roll = std::atan2(up_in_base.y(), up_in_base.z());
    velocity.angular.x() = kTurningGain * (-kBank * velocity.angular.z() - roll);
    velocity.angular.y() = -kTurningGain * elevation;
  }
  return velocity;
}

}  // namespace kinect_ekf_slam
