#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/fusion/global_map.h"
#include "kinect_ekf_slam/study/buoy_world.h"
#include "kinect_ekf_slam/study/monte_carlo.h"

namespace kinect_ekf_slam {

/// One globally consistent map out of local maps and buoys, as in the source's algorithm 3.
struct GlobalStudy {
  BuoyScenario scenario;
  int seeds = 50;
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

/// What one run came to. Errors in m, in the world's frame.
struct GlobalRun {
  std::size_t local_maps = 0;
  std::size_t joined = 0;         ///< local maps that had to be joined with a neighbour
  std::size_t unplaced = 0;       ///< segments that could not be placed
  int merged_landmarks = 0;       ///< found again in another local map
  std::size_t disagreements = 0;  ///< global positions that did not overlap with the path
  double path_rmse = 0.0;         ///< of the global map
  double landmark_rmse = 0.0;
  double slam_path_rmse = 0.0;  ///< SLAM alone, its start known
  double slam_landmark_rmse = 0.0;
  double beacon_path_rmse = 0.0;      ///< buoys alone
  std::vector<double> path_nees;      ///< of the position, once a second
  std::vector<double> landmark_nees;  ///< by the true landmark; NaN: not in the map
};

struct GlobalSummary {
  std::vector<GlobalRun> runs;
  double path_rmse = 0.0;  ///< m, over runs and times; likewise the others
  double landmark_rmse = 0.0;
  double slam_path_rmse = 0.0;
  double slam_landmark_rmse = 0.0;
  double beacon_path_rmse = 0.0;
  Consistency path;
  Consistency landmarks;  ///< at each landmark instead of each time; those that are mapped in all runs
};

/// For a picture: what was true, what each sensor made of it, and the global map, of one run. A point a row.
struct GlobalExample {
  std::vector<std::vector<double>> truth, slam, beacons, landmarks, true_landmarks, global_positions;
  std::vector<std::vector<std::vector<double>>> segments;  ///< their paths
};

GlobalSummary run_study(const GlobalStudy& study, GlobalExample* example = nullptr);

/// For people, and the same figures for programs (scripts/plot_global.py).
std::string to_table(const GlobalSummary& summary);
std::string to_json(const GlobalSummary& summary, const GlobalExample& example);

}  // namespace kinect_ekf_slam
