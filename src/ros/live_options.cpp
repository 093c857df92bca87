#include "kinect_ekf_slam/ros/live_options.h"

#include <cmath>

namespace kinect_ekf_slam {
namespace {

/// Calls `pair(option, live value)` for every parameter that both know.
template <class Options, class Config, class Pair>
void for_each(Options& options, Config& config, const Pair& pair) {
  auto& input = options.pipeline.input;
  auto& motion = options.pipeline.motion;
  auto& sensor = options.pipeline.sensor;
  pair(input.max_linear_speed, config.input_max_linear_speed);
  pair(input.max_angular_speed, config.input_max_angular_speed);
  pair(input.linear_scale, config.input_linear_scale);
  pair(input.angular_scale, config.input_angular_scale);
  pair(input.estimate_gyro_bias, config.input_estimate_gyro_bias);
  pair(motion.linear_noise, config.motion_linear_noise);
  pair(motion.linear_noise_per_speed, config.motion_linear_noise_per_speed);
  pair(motion.lateral_noise_per_speed, config.motion_lateral_noise_per_speed);
  pair(motion.angular_noise, config.motion_angular_noise);
  pair(motion.angular_noise_per_rate, config.motion_angular_noise_per_rate);
  pair(motion.angular_noise_per_speed, config.motion_angular_noise_per_speed);
  pair(motion.gyro_noise, config.motion_gyro_noise);
  pair(motion.gyro_noise_per_rate, config.motion_gyro_noise_per_rate);
  pair(sensor.min_depth, config.sensor_min_depth);
  pair(sensor.max_depth, config.sensor_max_depth);
  pair(sensor.max_lateral, config.sensor_max_lateral);
  pair(sensor.range_scale, config.sensor_range_scale);
  pair(options.output.marker_sigmas, config.output_marker_sigmas);
}

}  // namespace

SlamConfig to_live_config(const RunOptions& options) {
  SlamConfig config = SlamConfig::__getDefault__();
  for_each(options, config, [](const auto& option, auto& live) { live = option; });
  return config;
}

bool is_finite(const SlamConfig& config) {
  RunOptions unused;
  bool finite = true;
  for_each(unused, config,
           [&](auto&, const auto& live) { finite = finite && std::isfinite(static_cast<double>(live)); });
  return finite;
}

void apply_live_config(const SlamConfig& config, RunOptions* options) {
  for_each(*options, config, [](auto& option, const auto& live) { option = live; });
}

}  // namespace kinect_ekf_slam
