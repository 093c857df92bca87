#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/options.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// A robot that drives the world's round again and again: what grows, although the world does not?
struct PatrolStudy {
  World world;
  PipelineOptions pipeline;
  std::uint64_t seed = 1;
  int minutes = 60;                         ///< of simulated time
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

/// A twelfth of the patrol.
struct PatrolStretch {
  double minutes = 0.0;       ///< since the start, at its end
  std::size_t landmarks = 0;  ///< in the map then
  double megabytes = 0.0;     ///< of memory that the whole program holds then
  double update_ms = 0.0;     ///< of work per frame with detections, median over the stretch
};

std::vector<PatrolStretch> run_study(const PatrolStudy& study);

/// From the end of the first stretch, when the robot has been everywhere, to the end of the patrol: at most
/// one landmark and 1 MB more, and at most a quarter slower.
bool is_flat(const std::vector<PatrolStretch>& patrol);

std::string to_table(const std::vector<PatrolStretch>& patrol);

}  // namespace kinect_ekf_slam
