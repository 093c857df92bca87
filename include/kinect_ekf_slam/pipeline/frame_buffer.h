#pragma once

#include <algorithm>
#include <deque>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"

namespace kinect_ekf_slam {

/// Puts the frames of several sensors into the order of their stamps.
///
/// Detections come late: pictures take time. So odometry and gyro wait until the detections of their time
/// have come, or until they are older than `detection_delay`, counted in the data's own time so that a replay
/// decides as the live run did. Likewise all waits for positions and ranges, by `position_delay`, once there
/// have been any. Bounded by the delays and by `max_frames`.
class FrameBuffer {
 public:
  /// The delays in seconds.
  FrameBuffer(double detection_delay, std::size_t max_frames, double position_delay = 0.0)
      : detections_{to_nanoseconds(detection_delay), {}},
        positions_{to_nanoseconds(position_delay), {}},
        max_frames_(max_frames) {}

  /// Takes one frame; returns those that are due now, in the order of their stamps.
  std::vector<SensorFrame> add(SensorFrame frame);

  /// What is still waiting, in order.
  const std::deque<SensorFrame>& waiting() const { return waiting_; }

  /// All that waits, in order; afterwards the buffer is empty.
  std::vector<SensorFrame> flush();

 private:
  /// What comes late.
  struct Source {
    TimeNs delay;
    std::optional<TimeNs> last;  ///< stamp of the newest that has come
    /// Nothing of it is to be waited for up to this time.
    TimeNs horizon(TimeNs newest) const { return std::max(newest - delay, last.value_or(newest - delay)); }
    void note(TimeNs stamp) { last = std::max(stamp, last.value_or(stamp)); }
  };
  std::vector<SensorFrame> release_until(TimeNs stamp);

  Source detections_;
  Source positions_;
  std::size_t max_frames_;
  std::deque<SensorFrame> waiting_;
};

}  // namespace kinect_ekf_slam
