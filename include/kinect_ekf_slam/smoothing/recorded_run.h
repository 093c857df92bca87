#pragma once

#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// The velocity that moved the filter from `stamp` on.
struct RecordedVelocity {
  TimeNs stamp = 0;
  BodyVelocity velocity;
  double hold_time = 0.0;  ///< s; beyond that nobody knows
};

/// Where a filter believed the base to be.
template <class Space>
struct RecordedPose {
  TimeNs stamp = 0;
  typename Space::Pose map_from_base;
};

/// A sighting, as the sensor told it, of a landmark of the run.
struct RecordedSighting {
  TimeNs stamp = 0;
  Detection detection;  ///< nothing corrected yet
  int landmark = 0;     ///< index in the run's landmarks
};

/// All that the batch optimum needs of a run, in the order of time.
template <class Space>
struct RecordedRun {
  std::vector<RecordedVelocity> velocities;
  std::vector<RecordedSighting> sightings;
  std::vector<RecordedPose<Space>> path;  ///< one pose at least at every sighting's stamp
  /// Of the first pose: what anchors the map. Errors in the axes of the map.
  typename Space::PoseMatrix start_covariance = Space::PoseMatrix::Identity();
  std::vector<typename Space::Point> landmarks_in_map;  ///< m, as the filter left them
};

}  // namespace kinect_ekf_slam
