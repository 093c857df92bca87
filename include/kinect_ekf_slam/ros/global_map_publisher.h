#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/ros.h>

#include <future>
#include <memory>
#include <string>

#include "kinect_ekf_slam/pipeline/global_mapper.h"
#include "kinect_ekf_slam/ros/markers.h"
#include "kinect_ekf_slam/ros/run_options.h"

namespace kinect_ekf_slam {

/// Makes a global map beside the filter each global_map/period, and publishes it. Local maps grow with the
/// frames; putting them together is left to another thread, so that the filter does not wait.
class GlobalMapPublisher {
 public:
  /// Throws std::invalid_argument when the options allow no global map.
  GlobalMapPublisher(const ros::NodeHandle& private_handle, const RunOptions& options);

  void add(const SensorFrame& frame);
  /// The robot is elsewhere all at once.
  void break_path() { mapper_->break_path(); }
  /// A new run: all is forgotten.
  void restart();

  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  void poll();
  void publish();

  ros::NodeHandle private_handle_;
  RunOptions options_;
  std::unique_ptr<GlobalMapper> mapper_;
  MarkerPainter painter_;
  GlobalMap3d map_;  ///< the last one
  std::string failure_;
  std::future<GlobalMap3d> next_;
  bool next_is_of_this_run_ = true;
  bool has_news_ = false;  ///< frames have come since the last one was begun
  TimeNs newest_ = 0;
  ros::WallTime begun_;
  ros::Publisher map_publisher_;
  ros::Publisher marker_publisher_;
  ros::WallTimer timer_;
};

}  // namespace kinect_ekf_slam
