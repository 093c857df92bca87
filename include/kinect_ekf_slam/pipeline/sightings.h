#pragma once

#include <cstddef>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"
#include "kinect_ekf_slam/models/sensor_model.h"

namespace kinect_ekf_slam {

/// What of a message's detections can enter an estimate: in the sensor's range, finite, with a covariance.
template <class Space>
struct Sightings {
  std::vector<Observation<Space>> observations;
  std::vector<std::size_t> detection_of_observation;
  std::vector<Verdict> refusals;  ///< one a detection: why it is no observation; kInvalid where it is one

  Sightings(const std::vector<Detection>& detections, const SensorOptions& options);
};

}  // namespace kinect_ekf_slam
