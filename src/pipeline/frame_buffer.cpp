#include "kinect_ekf_slam/pipeline/frame_buffer.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kinect_ekf_slam {

std::vector<SensorFrame> FrameBuffer::add(SensorFrame frame) {
  const TimeNs stamp = frame.stamp;
  if (frame.detections) detections_.note(stamp);
  if (frame.tells_position()) positions_.note(stamp);
  // Behind all frames of the same stamp: the order of arrival decides between equals.
  const auto place =
      std::upper_bound(waiting_.begin(), waiting_.end(), stamp,
                       [](TimeNs time, const SensorFrame& other) { return time < other.stamp; });
  waiting_.insert(place, std::move(frame));
  const TimeNs newest = waiting_.back().stamp;
  TimeNs horizon = detections_.horizon(newest);
  if (positions_.last) horizon = std::min(horizon, positions_.horizon(newest));
  std::vector<SensorFrame> due = release_until(horizon);
  while (waiting_.size() > max_frames_) {
    due.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
  return due;
}

std::vector<SensorFrame> FrameBuffer::flush() {
  return waiting_.empty() ? std::vector<SensorFrame>() : release_until(waiting_.back().stamp);
}

std::vector<SensorFrame> FrameBuffer::release_until(TimeNs stamp) {
  const auto end = std::upper_bound(waiting_.begin(), waiting_.end(), stamp,
                                    [](TimeNs time, const SensorFrame& other) { return time < other.stamp; });
  std::vector<SensorFrame> due(std::make_move_iterator(waiting_.begin()), std::make_move_iterator(end));
  waiting_.erase(waiting_.begin(), end);
  return due;
}

}  // namespace kinect_ekf_slam
