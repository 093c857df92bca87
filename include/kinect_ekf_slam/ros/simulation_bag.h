#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// Stamp of the first sample in simulated bags. Fixed, as everything in them: the same world and seed give
/// the same bytes.
constexpr TimeNs kSimulationStart = 1'000'000'000'000;  // 1000 s

struct SimulationBagRequest {
  World world;
  std::uint64_t seed = 1;
  std::string bag;
  double duration = 0.0;  ///< s; 0: until the robot has stood at its last waypoint for a second
  std::function<void(double)> on_progress;  ///< s of simulated time; may be empty
};

/// Writes what a robot in that world would have recorded, and the truth. Returns the seconds in the bag. The
/// file appears under its name only when complete. Throws std::runtime_error with one line when the bag
/// cannot be written.
double write_simulation_bag(const SimulationBagRequest& request);

}  // namespace kinect_ekf_slam
