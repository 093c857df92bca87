#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/slam_result.h"
#include "kinect_ekf_slam/ros/sensor_bridge.h"

namespace kinect_ekf_slam {

/// Keeps count of what goes on and tells it as diagnostics: are the inputs alive, is the estimate sound?
class Health {
 public:
  struct Expectation {
    std::string odometry_topic;
    std::string imu_topic;
    std::string landmarks_topic;
    std::map<std::string, std::string> position_topics;  ///< those that are listened to, by the input's name
    double position_sigma_warning = 0.5;                 ///< m
    Eigen::Index position_axes = 2;                      ///< that are estimated: 2 in the plane, 3 in space
  };

  Health(Expectation expectation, const ros::Time& start)
      : expectation_(std::move(expectation)), start_(start), last_report_(start) {}

  /// A message that is used; `received`: when it came to the node, where it waits for its turn.
  void note_input(const std::string& input, const ros::Time& now, const ros::Time& received);
  void note_result(const SlamResult& result);
  void note_pose(const Pose3d& pose) { pose_ = pose; }
  void note_map(std::size_t landmarks) { landmarks_ = landmarks; }
  /// What became of the last autosave, in words.
  void note_autosave(const std::string& outcome, bool sound);
  void set_state(const std::string& mode, bool paused);
  /// A new run: what was counted of the estimate is forgotten, what was counted of the inputs is not.
  void reset_estimate();

  void report_inputs(const SensorBridge& bridge, const ros::Time& now,
                     diagnostic_updater::DiagnosticStatusWrapper& status);
  void report_estimate(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  struct Input {
    ros::Time last;
    std::uint64_t since_report = 0;
    double longest_wait = 0.0;  ///< s, since the last report
    std::uint64_t refused = 0;  ///< at the last report
  };

  Expectation expectation_;
  ros::Time start_;
  ros::Time last_report_;
  std::map<std::string, Input> inputs_;
  std::vector<std::uint64_t> verdicts_ = std::vector<std::uint64_t>(kVerdictCount, 0);
  std::vector<std::uint64_t> position_verdicts_ = std::vector<std::uint64_t>(kPositionVerdictCount, 0);
  bool is_aligned_ = false;   ///< it is known where the map lies in the frame of global positions
  double nis_per_dof_ = 1.0;  ///< exponential mean; 1 is what a consistent filter shows
  std::uint64_t updates_ = 0;
  std::uint64_t looked_ = 0;       ///< frames with detections, or with none
  std::uint64_t saw_nothing_ = 0;  ///< of those the empty ones
  bool finite_ = true;
  Localization localization_ = Localization::kTracking;
  Pose3d pose_;
  std::size_t landmarks_ = 0;
  std::string mode_ = "slam";
  bool paused_ = false;
  std::string autosave_;  ///< what became of the last one; empty: there was none
  bool autosave_sound_ = true;
};

}  // namespace kinect_ekf_slam
