#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/pipeline/sensor_frame.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// Writes what a run produced as files for evaluation: `trajectory.tum`, `trajectory_covariance.csv`,
/// `dead_reckoning.tum`, `positions.csv` (positions in the map and ranges, and what became of them),
/// `beacons.csv` (as known at the end), `landmarks.csv` (the confirmed ones), `associations.csv` (as known at
/// the end), `associations_instant.csv` (as told at once), `parameters.yaml` (as given: the same run again
/// with `slam_replay --config`) and `summary.json` (counts, times, warnings, versions). Files appear under
/// their names only when complete. Throws std::runtime_error, naming the file, when one cannot be written.
class RunWriter {
 public:
  /// `trajectory_rate` in Hz besides the frames with detections; 0: every frame.
  RunWriter(const std::string& directory, double trajectory_rate);
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  /// Forgets what was added: a new run begins.
  void restart();

  void add(const SensorFrame& frame, const SlamResult& result);
  void add_position(TimeNs stamp, const PositionOutcome& outcome);

  struct Summary {
    std::string bag;
    std::string parameters;             ///< YAML that the run's options were read from
    std::vector<std::string> warnings;  ///< one line each
    double wall_seconds = 0.0;
    double cpu_seconds = 0.0;
    double data_seconds = 0.0;
    std::vector<double> update_milliseconds;  ///< of each frame with detections
    std::map<std::string, std::uint64_t> refusals;
    std::map<std::string, std::uint64_t> accepted;
  };
  void write_beacons(const std::vector<Landmark3d>& beacons);
  void finish(const std::vector<Landmark3d>& map, const Summary& summary);

  /// What became of a detection.
  struct AssociationRow {
    TimeNs stamp;
    int detection;
    int source_id;
    Verdict verdict;
    int landmark;
    double nis;
  };
  /// As known at the end, ordered by stamp and detection; once finished.
  const std::vector<AssociationRow>& associations() const { return rows_; }
  /// True when a pose of this stamp would be written.
  bool wants_pose(TimeNs stamp, bool looked) const;

 private:
  struct File {
    std::string name;
    std::string text;
  };
  void settle_rows(const std::vector<Landmark3d>& map);
  void revise(const SlamResult& result);
  static std::string to_csv(const std::vector<AssociationRow>& rows);
  static std::string landmark_rows(const std::vector<Landmark3d>& map);
  void write_summary(const std::vector<Landmark3d>& map, const Summary& summary);

  std::string directory_;
  TimeNs period_;
  TimeNs last_written_ = 0;
  bool has_written_ = false;
  std::vector<AssociationRow> rows_;          ///< as is known now
  std::vector<AssociationRow> instant_rows_;  ///< as was told at once
  std::vector<std::pair<int, int>> merged_;   ///< landmarks, in the order of time: the first is the second
  std::set<int> removed_;
  std::uint64_t frames_ = 0;
  std::uint64_t detection_frames_ = 0;
  File trajectory_{"trajectory.tum", ""};
  File covariance_{"trajectory_covariance.csv", ""};
  File dead_reckoning_{"dead_reckoning.tum", ""};
  File positions_{"positions.csv", ""};
  File beacons_{"beacons.csv", ""};
  std::map<std::string, std::uint64_t> position_verdicts_;
  std::optional<Eigen::Isometry3d> map_from_global_;
  File associations_{"associations.csv", ""};
  File instant_associations_{"associations_instant.csv", ""};
  File landmarks_{"landmarks.csv", ""};
  File parameters_{"parameters.yaml", ""};
  File summary_{"summary.json", ""};
};

/// Removes the folder of an earlier run with all that is in it; one that holds no `trajectory.tum` is
/// somebody else's and stays. Throws std::runtime_error, naming the folder, when it cannot be removed.
void remove_run(const std::string& directory);

}  // namespace kinect_ekf_slam
