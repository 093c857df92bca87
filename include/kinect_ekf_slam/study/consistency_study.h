#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/models/sensor_model.h"
#include "kinect_ekf_slam/study/monte_carlo.h"

namespace kinect_ekf_slam {

/// A room of 10 m x 8 m with 18 landmarks of known identity along a closed way, and a robot that drives it
/// again and again with white noise on its odometry: all that a filter assumes is true, so what its
/// covariance gets wrong is the filter's own doing. In space the way climbs, falls and banks, and landmarks
/// stand high and low.
struct ConsistencyScenario {
  int loops = 10;
  double speed = 0.5;               ///< m/s
  double rate = 10.0;               ///< Hz, of odometry and sensor
  double linear_sigma = 0.05;       ///< m/s, of the forward speed in each odometry
  double angular_sigma_deg = 5.0;   ///< deg/s, of each turn rate
  double field_of_view_deg = 57.0;  ///< horizontal, whole angle
  double vertical_field_of_view_deg = 43.0;
  SensorOptions sensor;  ///< its range gate and noise model
};

/// What one estimator made of many runs.
struct ConsistencyResult {
  std::string estimator;       ///< as `estimator/type` names it
  Consistency pose;            ///< NEES with the pose's degrees of freedom
  double position_rmse = 0.0;  ///< m, over runs and times
  double rotation_rmse = 0.0;  ///< rad
  double landmark_rmse = 0.0;  ///< m, at the end of the runs, in the start's frame
  /// The first run, at each time: error along x, y and about the vertical, and its standard deviation.
  std::vector<std::vector<double>> example_error;
  std::vector<std::vector<double>> example_sigma;
};

/// The same `seeds` runs through each of the estimators.
template <class Space>
std::vector<ConsistencyResult> run_consistency(const ConsistencyScenario& scenario,
                                               const std::vector<EstimatorOptions::Type>& estimators,
                                               int seeds, const std::function<void(double)>& on_progress);

/// For people, and the same figures with their course over time for programs (scripts/plot_consistency.py).
std::string to_table(const std::vector<ConsistencyResult>& results);
std::string to_json(const std::vector<ConsistencyResult>& results);

}  // namespace kinect_ekf_slam
