#pragma once

#include <kinect_ekf_slam/SlamConfig.h>

#include "kinect_ekf_slam/ros/run_options.h"

namespace kinect_ekf_slam {

/// The parameters that dynamic_reconfigure shows, and what it changes in them.
SlamConfig to_live_config(const RunOptions& options);
/// False when a value is NaN or infinite: dynamic_reconfigure lets those pass.
bool is_finite(const SlamConfig& config);
void apply_live_config(const SlamConfig& config, RunOptions* options);

}  // namespace kinect_ekf_slam
