#pragma once

namespace kinect_ekf_slam {

/// When a new local map starts.
struct LocalMapOptions {
  int min_matches = 3;               ///< landmarks that a look must match, or the map does not hold the robot
  double gap_time = 3.0;             ///< s without such a look end the map, once there has been one
  double max_position_sigma = 0.3;   ///< m along the worst axis, in the map's own frame
  double max_turn_sigma_deg = 10.0;  ///< deg, likewise
  double path_interval = 1.0;        ///< s between the path points
  int max_path_points = 150;         ///< more end the map: they are part of the filter's state
};

}  // namespace kinect_ekf_slam
