#pragma once

#include <cstdint>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// Drives about without knowing where it is: stands, looks round once, then goes straight on and turns where
/// it is stopped, and now and then for a change.
class Wanderer {
 public:
  explicit Wanderer(std::uint64_t seed) : random_(seed, 0) {}

  /// Velocity to strive for, given what the wheels say now.
  BodyVelocity command(TimeNs now, const BodyVelocity& odometry);

 private:
  void turn(TimeNs now, double angle);

  RandomStream random_;
  bool started_ = false;
  double turn_rate_ = 0.0;  ///< rad/s, until `turn_end_`
  TimeNs turn_end_ = 0;
  TimeNs straight_end_ = 0;
};

}  // namespace kinect_ekf_slam
