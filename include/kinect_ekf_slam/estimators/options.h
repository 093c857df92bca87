#pragma once

namespace kinect_ekf_slam {

struct EstimatorOptions {
  enum class Type { kEkf, kInvariantEkf, kUkf, kFastSlam1, kFastSlam2, kDeadReckoning };
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
  double resample_below = 0.5;  ///< share of the particles; resampled when fewer are effective
  enum class MotionTail { kGaussian, kCauchy };
  MotionTail motion_tail = MotionTail::kGaussian;  ///< kCauchy: now and then an error of many sigma
  int seed = 1;
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
    {"ukf", EstimatorOptions::Type::kUkf, "sigma points instead of Jacobians"},
    {"fastslam1", EstimatorOptions::Type::kFastSlam1, "particles drawn from the motion"},
    {"fastslam2", EstimatorOptions::Type::kFastSlam2, "particles drawn from motion and sightings"},
    {"dead_reckoning", EstimatorOptions::Type::kDeadReckoning,
     "open loop, landmarks are plotted where they are seen"},
};

}  // namespace kinect_ekf_slam
