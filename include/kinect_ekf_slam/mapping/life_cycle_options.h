#pragma once

namespace kinect_ekf_slam {

/// When a landmark is believed in. As they stand here, always; config/slam.yaml has what suits a robot.
struct LifeCycleOptions {
  /// A new landmark is provisional until this many sightings agree on it; 1: none is.
  int confirm_sightings = 1;
  /// m or rad that the robot has moved or turned since a landmark's first sighting before it is confirmed: an
  /// error that stands still before a robot that stands still must not become a landmark.
  double confirm_motion = 0.05;
  double confirm_time =
      0.0;  ///< s from its first sighting to its last before it is confirmed: a burst is over sooner
  double forget_after = 6.0;  ///< s that a provisional landmark may be unseen
  /// m; nearer ones that may be one, and are not seen together, become one; 0: never.
  double merge_distance = 0.0;
  double merge_probability = 0.999999;  ///< of the gate for their difference
  /// A landmark is taken off when the robot has looked at its place so often, on separate visits, and not
  /// seen it on any since; sooner when few sightings support it. 0: never.
  int remove_after_visits = 0;
  // What the sensor sees, for that: about the base's forward axis.
  double field_of_view_deg = 57.0;           ///< whole angle
  double vertical_field_of_view_deg = 43.0;  ///< likewise; in space only
  double view_range = 2.6;                   ///< m from the base
};

}  // namespace kinect_ekf_slam
