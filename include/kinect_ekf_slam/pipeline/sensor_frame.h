#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// What the sensors said at one time, in the base frame. A frame carries what is new and leaves out the rest.
struct SensorFrame {
  TimeNs stamp = 0;
  std::optional<BodyVelocity> odometry;              ///< holds from now until the next
  std::optional<Eigen::Vector3d> gyro_rate;          ///< rad/s, likewise
  std::optional<std::vector<Detection>> detections;  ///< empty: looked, saw nothing; absent: did not look
  std::optional<GlobalPosition> position;            ///< in the map
  std::optional<GlobalPosition> global_position;  ///< in the frame of global positions, wherever the map lies
  std::vector<BeaconRange> ranges;

  bool tells_position() const { return position || global_position || !ranges.empty(); }
};

}  // namespace kinect_ekf_slam
