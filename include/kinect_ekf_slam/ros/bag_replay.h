#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/global_run.h"
#include "kinect_ekf_slam/ros/run_options.h"
#include "kinect_ekf_slam/ros/run_refiner.h"

namespace kinect_ekf_slam {

struct ReplayRequest {
  std::string bag;
  std::string output_directory;  ///< empty: write nothing
  bool refine = false;           ///< also write the batch optimum, to `refined` in the output directory
  bool global = false;           ///< also write one map in the frame of global positions, to `global` there
  RunOptions options;
  std::vector<std::string> warnings;        ///< of the options, one line each, to be kept with the results
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

/// What one replay found, for the last line of a tool.
struct ReplayReport {
  double data_seconds = 0.0;
  double wall_seconds = 0.0;
  std::size_t landmarks = 0;
  std::size_t detection_frames = 0;
  std::size_t new_runs = 0;  ///< times that the bag's clock went back; files and map are of the last run
  std::map<std::string, std::uint64_t> refusals;  ///< "input: reason" -> messages refused for it
  std::vector<std::string> warnings;              ///< what was odd about the bag, one line each
  std::optional<RefinementReport> refinement;
  std::optional<GlobalRunReport> global;
};

/// Runs a bag through the same session as the live node: no master, no wall clock.
/// Throws std::runtime_error with one line when the bag or the output folder cannot be used.
ReplayReport replay_bag(const ReplayRequest& request);

}  // namespace kinect_ekf_slam
