#pragma once

namespace kinect_ekf_slam {

struct LifeCycleOptions {
  /// A new landmark is provisional until this many sightings agree on it; 1: none is.
  int confirm_sightings = 5;
  /// m or rad that the robot has moved or turned since a landmark's first sighting before it is confirmed: an
  /// error that stands still before a robot that stands still must not become a landmark.
  double confirm_motion = 0.05;
  double forget_after = 6.0;  ///< s that a provisional landmark may be unseen
  double merge_distance =
      0.0;  ///< m; nearer ones that may be one, and are not seen together, become one; 0: never
  double merge_probability = 0.99;  ///< of the gate for their difference
  /// A landmark is taken off when the robot has looked at its place so often, on separate visits, and not
  /// seen it on any since; sooner when few sightings support it. 0: never.
  int remove_after_visits = 0;
  double field_of_view_deg = 57.0;  ///< whole angle about the base's forward axis, for that
  double view_range = 2.6;          ///< m from the base

  /// What is mapped stays.
  static LifeCycleOptions none() {
    LifeCycleOptions options;
    options.confirm_sightings = 1;
    options.merge_distance = 0.0;
    options.remove_after_visits = 0;
    return options;
  }
};

}  // namespace kinect_ekf_slam
