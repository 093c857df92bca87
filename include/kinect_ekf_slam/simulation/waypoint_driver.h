#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// Drives through the waypoints: turns towards the next one, slows where the way bends, stops at the last.
/// One that flies also points its nose up or down at it, and banks into turns.
class WaypointDriver {
 public:
  explicit WaypointDriver(const DriveOptions& options) : options_(options) {}

  /// Velocity to strive for, `now` from the start of the run.
  BodyVelocity command(TimeNs now, const Eigen::Isometry3d& world_from_base);

  /// The last waypoint of the last loop is reached.
  bool done() const { return next_ >= waypoint_count(); }

 private:
  std::size_t waypoint_count() const {
    return options_.waypoints_in_world.size() * static_cast<std::size_t>(options_.loops);
  }

  DriveOptions options_;
  std::size_t next_ = 0;  ///< counted through all loops
};

}  // namespace kinect_ekf_slam
