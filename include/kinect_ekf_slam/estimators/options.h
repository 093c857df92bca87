#pragma once

namespace kinect_ekf_slam {

struct EstimatorOptions {
  enum class Type { kEkf, kInvariantEkf, kCompressedEkf, kUkf, kDeadReckoning };
  Type type = Type::kEkf;
  /// An accepted observation whose squared Mahalanobis distance exceeds this has its noise inflated in the
  /// same proportion, so that an unlikely sighting pulls less; 0: never.
  double robust_threshold = 6.0;
  /// Association by identity: a landmark that this many sightings in a row contradict, and no more than as
  /// many support, was misplaced (a misread identity) and is placed anew; 0: never.
  int replace_after = 3;
  int max_landmarks = 2000;  ///< more are refused
  // Compressed EKF. The estimate does not depend on them, its speed does: with a sensor that sees no farther
  // than active_radius (1 - active_hysteresis) the active region changes only where the robot has moved on.
  double active_radius = 10.0;      ///< m from the robot: landmarks that become active
  double active_hysteresis = 0.25;  ///< share of the radius that the robot moves before the region changes
};

}  // namespace kinect_ekf_slam
