#pragma once

#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// What was known of something at one time.
template <class Value>
struct Stamped {
  TimeNs stamp = 0;
  Value value;
};

}  // namespace kinect_ekf_slam
