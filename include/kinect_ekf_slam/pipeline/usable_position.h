#pragma once

#include "kinect_ekf_slam/core/position.h"

namespace kinect_ekf_slam {

/// Finite, on the Earth, and with a covariance that says something.
bool is_usable(const GlobalPosition& position);
bool is_usable(const BeaconRange& range);

}  // namespace kinect_ekf_slam
