#pragma once

#include <algorithm>

#include "kinect_ekf_slam/models/motion.h"

namespace kinect_ekf_slam {

/// The motion over `dt` seconds by a velocity that holds for the first `hold_time` of them. What comes after
/// nobody knows: taken for none, give or take `last_known` each second.
template <class Space>
MotionStep<Space> held_motion_step(const BodyVelocity& velocity, double hold_time, double dt,
                                   const BodyVelocity& last_known, const MotionOptions& options) {
  const double held = std::clamp(hold_time, 0.0, dt);
  MotionStep<Space> step;
  if (held > 0.0) step = motion_step<Space>(velocity, held, options);
  if (held < dt) step.covariance += (Space::twist(last_known).cwiseAbs2() * (dt - held)).asDiagonal();
  return step;
}

}  // namespace kinect_ekf_slam
