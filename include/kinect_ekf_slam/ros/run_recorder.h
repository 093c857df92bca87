#pragma once

#include <vector>

#include "kinect_ekf_slam/models/input_conditioner.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// Keeps what a run is refined from: what moved the filter, what it saw, and where it believed to be.
class RunRecorder {
 public:
  struct Frame {
    TimeNs stamp = 0;
    Eigen::Isometry3d map_from_base;  ///< the filter's
    BodyVelocity velocity;            ///< from now on, calibrated as configured
    double hold_time = 0.0;           ///< s
    bool looked = false;
    std::vector<Detection> detections;  ///< nothing corrected yet
  };

  explicit RunRecorder(const InputOptions& input) : input_(input), conditioner_(input) {}

  /// Forgets what was added: a new run begins.
  void restart();
  void add(const SensorFrame& frame, const SlamResult& result);

  const std::vector<Frame>& frames() const { return frames_; }
  /// The filter's first pose.
  const Pose3d& start() const { return start_; }
  /// Something besides landmarks told where the robot is.
  bool has_positions() const { return has_positions_; }

 private:
  InputOptions input_;
  InputConditioner conditioner_;
  std::vector<Frame> frames_;
  Pose3d start_;
  bool has_positions_ = false;
};

}  // namespace kinect_ekf_slam
