#pragma once

#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/global_mapper.h"
#include "kinect_ekf_slam/pipeline/options.h"

namespace kinect_ekf_slam {

struct StaticTransformOption {
  std::string parent;
  std::string child;
  std::vector<double> xyz;      ///< m
  std::vector<double> rpy_deg;  ///< deg, fixed axes roll, pitch, yaw
};

struct FrameOptions {
  std::string map = "map";
  std::string odom = "odom";
  std::string base = "base_footprint";
  double tf_timeout = 0.1;  ///< s
  std::vector<StaticTransformOption> static_transforms;
};

struct SyncOptions {
  std::string odometry_topic = "odom";
  std::string imu_topic = "imu";  ///< empty: no IMU
  std::string landmarks_topic = "landmarks";
  double max_interval = 0.07;  ///< s; the report's
  int queue_size = 200;
  double odometry_delay = 0.0;    ///< s; odometry stamped t is true at t + delay
  double detection_delay = 1.0;   ///< s; detections later than this are refused
  double position_delay = 0.5;    ///< s; likewise positions and ranges
  double future_tolerance = 1.0;  ///< s
  double time_jump = 1.0;         ///< s back in time that make a new run
};

/// What else tells where the robot is.
struct FusionOptions {
  std::string frame = "earth";  ///< of global positions
  std::string positions_topic = "global_position";
  std::string fix_topic;  ///< empty: no GPS
  std::string ranges_topic = "beacon_ranges";
  std::string antenna_frame;  ///< that global positions speak of; empty: frames/base
  std::vector<double> datum;  ///< latitude deg, longitude deg, altitude m; empty: the first fix
  double fix_sigma = 0.0;     ///< m, of a fix without covariance; 0: it is refused
};

/// When slam_node makes a global map; how: PipelineOptions::global_mapping.
struct GlobalMapOutput {
  bool enabled = false;
  double period = 10.0;  ///< s from one map to the next
};

struct MapOptions {
  std::string directory = "~/.ros/kinect_ekf_slam";
  std::string file_name = "map.yaml";
  bool load_at_start = false;
  bool save_at_exit = false;
  double autosave_period = 0.0;  ///< s; 0: off
};

struct OutputOptions {
  bool publish_tf = true;
  double transform_tolerance = 0.1;  ///< s that map -> odom is dated ahead
  double correction_time = 0.0;      ///< s, time constant; 0: corrections of map -> odom are shown at once
  double marker_sigmas = 3.0;
  double marker_rate = 5.0;         ///< Hz
  double path_step = 0.05;          ///< m
  int path_length = 10000;          ///< poses kept
  double trajectory_rate = 20.0;    ///< Hz, of slam_replay's files; 0: every frame
  double pose_sigma_warning = 0.5;  ///< m
};

/// Everything that a run depends on: one YAML file, one struct.
struct RunOptions {
  FrameOptions frames;
  SyncOptions sync;
  FusionOptions fusion;
  GlobalMapOutput global_map;
  PipelineOptions pipeline;
  MapOptions map;
  OutputOptions output;
  std::string text;  ///< the YAML that all this was read from, for map files
};

/// The frame that a global map is in.
inline const std::string& frame_of(const GlobalMap3d& map, const RunOptions& options) {
  return map.positions_in_map ? options.frames.map : options.fusion.frame;
}

}  // namespace kinect_ekf_slam
