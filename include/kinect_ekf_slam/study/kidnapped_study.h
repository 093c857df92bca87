#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/options.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// Robots that are put down anywhere in a room whose map was made before, and drive about until they know
/// where they are.
struct KidnappedStudy {
  World world;
  PipelineOptions pipeline;
  std::uint64_t first_seed = 1;
  int robots = 100;
  bool looks = true;                        ///< false: no labels and radii, neither seen nor in the map
  double patience = 300.0;                  ///< s; a robot that is still searching then is given up
  std::function<void(double)> on_progress;  ///< share done, 0 to 1, from the calling thread; may be empty
};

struct KidnappedRun {
  std::uint64_t seed = 0;
  bool found = false;           ///< the robot says that it knows where it is
  double seconds = 0.0;         ///< until then
  double position_error = 0.0;  ///< m, at that time, against the truth brought into the map
  double heading_error = 0.0;   ///< rad
  bool is_right() const;        ///< found, to 0.1 m and 5 degrees
};

/// Makes the map by SLAM with seed 0, and lets the robots look for themselves in it, on all cores.
std::vector<KidnappedRun> run_study(const KidnappedStudy& study);

std::string to_table(const std::string& title, const std::vector<KidnappedRun>& runs);

}  // namespace kinect_ekf_slam
