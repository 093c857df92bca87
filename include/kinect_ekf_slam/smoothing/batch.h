#pragma once

#include <functional>
#include <vector>

#include "kinect_ekf_slam/models/motion.h"
#include "kinect_ekf_slam/models/sensor_model.h"
#include "kinect_ekf_slam/smoothing/calibration.h"
#include "kinect_ekf_slam/smoothing/recorded_run.h"
#include "kinect_ekf_slam/smoothing/smoothed_path.h"

namespace kinect_ekf_slam {

struct BatchOptions {
  MotionOptions motion;
  SensorOptions sensor;  ///< with its `correlation_time`
  CalibrationPrior prior;
  /// Cauchy's: whitened errors of a sighting beyond it pull less the larger they are. sqrt(5) keeps 95 % of
  /// the efficiency for two normal numbers.
  double loss_scale = 2.2;
  int rounds = 10;            ///< at most: odometry, noise and correlations are taken anew in each
  double longest_step = 1.0;  ///< s between two poses of the optimum
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

/// What became of a sighting.
struct SightingOutcome {
  double squared_error = 0.0;  ///< whitened
  double weight = 1.0;         ///< the loss's: 1 where it is believed, towards 0 where it is not
};

/// The most probable path, map and calibration of a run, given all of it.
template <class Space>
struct BatchResult {
  struct Landmark {
    typename Space::Point in_map;
    typename Space::PointMatrix covariance;
    bool was_seen = false;  ///< else nothing is known of it here
  };
  SmoothedPath<Space> path;
  std::vector<Landmark> landmarks;  ///< of the run, in their order
  Calibration<Space> calibration;
  /// Joint covariance of the calibration: motion, then sensor.
  Eigen::MatrixXd calibration_covariance;
  std::vector<SightingOutcome> sightings;  ///< of the run, in their order
  double cost = 0.0;                       ///< half the sum of the squared errors, after the loss
  double mean_obliquity = 0.0;  ///< of the sightings: where the range's scale is that of the calibration
  int rounds = 0;
  bool converged = false;
};

/// Poses at every sighting and at least every `longest_step`, all landmarks, the calibration: the maximum of
/// their posterior with a robust loss (docs/theory.md, section 12). Throws std::invalid_argument when the
/// run has no path or no sighting, std::runtime_error when the optimum is not to be had.
template <class Space>
BatchResult<Space> batch_optimum(const RecordedRun<Space>& run, const BatchOptions& options);

}  // namespace kinect_ekf_slam
