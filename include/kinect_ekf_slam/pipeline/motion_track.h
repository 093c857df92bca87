#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "kinect_ekf_slam/models/held_motion.h"
#include "kinect_ekf_slam/models/input_conditioner.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"

namespace kinect_ekf_slam {

/// Carries something that moves from frame to frame: how far, and how surely.
template <class Space>
class MotionTrack {
 public:
  MotionTrack(const InputOptions& input, const MotionOptions& motion)
      : conditioner_(input), options_(motion) {}

  /// The steps from the last frame to `frame`; takes in what the frame says of what follows.
  std::optional<MotionStep<Space>> advance(const SensorFrame& frame) {
    std::optional<MotionStep<Space>> step = advance_to(frame.stamp);
    if (frame.odometry) conditioner_.add_odometry(frame.stamp, *frame.odometry);
    if (frame.gyro_rate) conditioner_.add_gyro(frame.stamp, *frame.gyro_rate);
    return step;
  }

  std::optional<MotionStep<Space>> advance_to(TimeNs stamp) {
    const TimeNs start = std::exchange(now_, started_ ? std::max(stamp, now_) : stamp);
    const double dt = to_seconds(now_ - start);
    if (!std::exchange(started_, true) || dt <= 0.0) return std::nullopt;
    return held_motion_step<Space>(conditioner_.velocity(start), conditioner_.hold_time(start), dt,
                                   conditioner_.last_odometry(), options_);
  }

  TimeNs now() const { return now_; }
  /// True for what has come too late: time has gone on.
  bool is_past(TimeNs stamp) const { return started_ && stamp < now_; }
  InputConditioner& conditioner() { return conditioner_; }
  const InputConditioner& conditioner() const { return conditioner_; }
  void set_options(const MotionOptions& options) { options_ = options; }

 private:
  InputConditioner conditioner_;
  MotionOptions options_;
  TimeNs now_ = 0;
  bool started_ = false;
};

}  // namespace kinect_ekf_slam
