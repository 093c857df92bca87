#pragma once

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam::testing {

/// Of a robot on the floor, m/s and rad/s.
inline BodyVelocity velocity(double forward, double turn) {
  BodyVelocity velocity;
  velocity.linear.x() = forward;
  velocity.angular.z() = turn;
  return velocity;
}

}  // namespace kinect_ekf_slam::testing
