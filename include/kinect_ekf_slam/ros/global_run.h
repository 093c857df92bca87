#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/global_mapper.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"
#include "kinect_ekf_slam/ros/run_options.h"
#include "kinect_ekf_slam/ros/run_writer.h"

namespace kinect_ekf_slam {

/// What a run looks like in the frame of global positions, for the last lines of a tool.
struct GlobalRunReport {
  std::string frame;
  std::size_t local_maps = 0;
  std::size_t segments = 0;
  std::size_t placed = 0;  ///< of them
  std::size_t landmarks = 0;
  int merged_landmarks = 0;  ///< that stood in several local maps
  std::size_t positions = 0;
  std::size_t left_out = 0;           ///< of them: they contradict the path
  std::vector<std::string> warnings;  ///< one line each
  double seconds = 0.0;
};

/// Makes the global map of a replay, and writes it.
class GlobalRun {
 public:
  /// Throws std::runtime_error with one line where the options allow no global map.
  explicit GlobalRun(const RunOptions& options);

  /// Forgets what was added: a new run begins.
  void restart();
  /// A frame, and what the filter made of it.
  void add(const SensorFrame& frame, const SlamResult& result);

  /// Writes the files of RunWriter to `directory`, in the global frame, with `segments.csv`: where each
  /// stretch of the way lies, or why that is not known. `summary` is the filter's. Throws std::runtime_error
  /// with one line when nothing could be placed.
  GlobalRunReport finish(const std::string& directory, const RunWriter::Summary& summary) const;

 private:
  struct DeadReckoned {
    TimeNs stamp = 0;
    Eigen::Isometry3d map_from_base;
  };
  void write_path(const GlobalMap3d& map, RunWriter* writer) const;
  const Eigen::Isometry3d& dead_reckoned_at(TimeNs stamp) const;

  const RunOptions& options_;
  std::unique_ptr<GlobalMapper> mapper_;
  std::vector<DeadReckoned> dead_reckoned_;  ///< a frame each
};

}  // namespace kinect_ekf_slam
