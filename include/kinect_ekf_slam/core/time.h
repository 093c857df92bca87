#pragma once

#include <cmath>
#include <cstdint>

namespace kinect_ekf_slam {

/// Time since the epoch of the run's clock in nanoseconds: exact, unlike seconds in a double.
using TimeNs = std::int64_t;

constexpr double kNanosecond = 1e-9;  ///< s

/// Difference of two times, or a duration, in seconds.
constexpr double to_seconds(TimeNs duration) { return static_cast<double>(duration) * kNanosecond; }

/// Seconds to the nearest nanosecond.
inline TimeNs to_nanoseconds(double seconds) { return std::llround(seconds / kNanosecond); }

}  // namespace kinect_ekf_slam
