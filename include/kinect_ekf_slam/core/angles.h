#pragma once

#include <cmath>

namespace kinect_ekf_slam {

constexpr double kPi = 3.14159265358979323846;

constexpr double radians(double degrees) { return degrees * kPi / 180.0; }
constexpr double degrees(double radians) { return radians * 180.0 / kPi; }

/// The same angle in (-pi, pi]. The only place where angles are wrapped.
inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);  // in [-pi, pi]
  return wrapped <= -kPi ? wrapped + 2.0 * kPi : wrapped;
}

}  // namespace kinect_ekf_slam
