#pragma once

#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/run_options.h"
#include "kinect_ekf_slam/smoothing/batch.h"

namespace kinect_ekf_slam {

/// An unknown of the calibration as a user reads it.
struct CalibratedValue {
  std::string name;  ///< the parameter's, where there is one
  std::string unit;
  double configured = 0.0;
  double value = 0.0;
  double sigma = 0.0;
  double prior_sigma = 0.0;
  bool is_parameter = true;
};

/// What the batch optimum of a run found, in terms of the parameters that the run had, and of where its
/// sensor stands.
template <class Space>
std::vector<CalibratedValue> calibrated_values(const BatchResult<Space>& result,
                                               const CalibrationPrior& prior, const RunOptions& options);

/// Value, sigma and what was configured, for a terminal.
std::string calibration_line(const CalibratedValue& value);

/// A configuration that read_run_options takes: a value that no parameter may have is the nearest that one
/// may. What is no parameter is a comment.
std::string calibration_yaml(const std::vector<CalibratedValue>& values, const std::string& bag);

/// An object with one member a value.
std::string calibration_json(const std::vector<CalibratedValue>& values);

}  // namespace kinect_ekf_slam
