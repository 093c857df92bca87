#pragma once

namespace kinect_ekf_slam {

struct EstimatorOptions {
  enum class Type { kEkf, kInvariantEkf, kCompressedEkf, kUkf, kFastSlam1, kFastSlam2, kDeadReckoning };
  Type type = Type::kInvariantEkf;
  /// An accepted observation whose squared Mahalanobis distance exceeds this has its noise inflated in the
  /// same proportion, so that an unlikely sighting pulls less; 0: never.
  double robust_threshold = 6.0;
  /// Association by identity: a landmark that this many sightings in a row contradict, and no more than as
  /// many support, was misplaced (a misread identity) and is placed anew; 0: never.
  int replace_after = 3;
  int max_landmarks = 2000;  ///< more are refused

  /// FastSLAM.
  int particles = 100;
  int draw_after = 10;  ///< landmarks that were seen before the pose is drawn; 1: drawn at each sighting
  double resample_below = 0.5;  ///< share of the particles; resampled when fewer are effective
  enum class MotionTail { kGaussian, kCauchy };
  MotionTail motion_tail = MotionTail::kGaussian;  ///< kCauchy: now and then an error of many sigma
  int seed = 1;

  // Compressed EKF. The estimate does not depend on them, its speed does: with a sensor that sees no farther
  // than active_radius (1 - active_hysteresis) the active region changes only where the robot has moved on.
  double active_radius = 10.0;      ///< m from the robot: landmarks that become active
  double active_hysteresis = 0.25;  ///< share of the radius that the robot moves before the region changes
};

/// How `estimator/type` calls the estimators.
struct EstimatorName {
  const char* name;
  EstimatorOptions::Type type;
  const char* meaning;
};
inline constexpr EstimatorName kEstimators[] = {
    {"ekf", EstimatorOptions::Type::kEkf, "the extended Kalman filter"},
    {"invariant_ekf", EstimatorOptions::Type::kInvariantEkf, "the same with the right-invariant error"},
    {"compressed_ekf", EstimatorOptions::Type::kCompressedEkf,
     "the EKF's numbers, most steps at a cost that the map's size does not change"},
    {"ukf", EstimatorOptions::Type::kUkf, "sigma points instead of Jacobians"},
    {"fastslam1", EstimatorOptions::Type::kFastSlam1, "particles drawn from the motion"},
    {"fastslam2", EstimatorOptions::Type::kFastSlam2, "particles drawn from motion and sightings"},
    {"dead_reckoning", EstimatorOptions::Type::kDeadReckoning,
     "open loop, landmarks are plotted where they are seen"},
};

}  // namespace kinect_ekf_slam
