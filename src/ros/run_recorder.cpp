#include "kinect_ekf_slam/ros/run_recorder.h"

#include <utility>

namespace kinect_ekf_slam {

void RunRecorder::restart() {
  conditioner_ = InputConditioner(input_);
  frames_.clear();
  has_positions_ = false;
}

void RunRecorder::add(const SensorFrame& frame, const SlamResult& result) {
  has_positions_ = has_positions_ || frame.tells_position();
  const bool late = !frames_.empty() && frame.stamp < frames_.back().stamp;
  if (late || !result.finite) return;
  if (frame.odometry) conditioner_.add_odometry(frame.stamp, *frame.odometry);
  if (frame.gyro_rate) conditioner_.add_gyro(frame.stamp, *frame.gyro_rate);
  if (frames_.empty()) start_ = result.pose;
  Frame kept;
  kept.stamp = frame.stamp;
  kept.map_from_base = result.pose.map_from_base;
  kept.velocity = conditioner_.velocity(frame.stamp);
  kept.hold_time = conditioner_.hold_time(frame.stamp);
  kept.looked = result.looked;
  if (frame.detections) kept.detections = *frame.detections;
  frames_.push_back(std::move(kept));
}

}  // namespace kinect_ekf_slam
