#pragma once

#include <deque>
#include <vector>

#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"

namespace kinect_ekf_slam {

/// Puts the frames of several sensors into the order of their stamps.
///
/// Detections come late: pictures take time. So odometry and gyro wait until the detections of their time
/// have come, or until they are older than `detection_delay`, counted in the data's own time so that a replay
/// decides as the live run did. Bounded by the delay and by `max_frames`.
class FrameBuffer {
 public:
  /// `detection_delay` in seconds.
  FrameBuffer(double detection_delay, std::size_t max_frames)
      : delay_(to_nanoseconds(detection_delay)), max_frames_(max_frames) {}

  /// Takes one frame; returns those that are due now, in the order of their stamps.
  std::vector<SensorFrame> add(SensorFrame frame);

  /// What is still waiting, in order.
  const std::deque<SensorFrame>& waiting() const { return waiting_; }

  /// All that waits, in order; afterwards the buffer is empty.
  std::vector<SensorFrame> flush();

 private:
  std::vector<SensorFrame> release_until(TimeNs stamp);

  TimeNs delay_;
  std::size_t max_frames_;
  std::deque<SensorFrame> waiting_;
};

}  // namespace kinect_ekf_slam
