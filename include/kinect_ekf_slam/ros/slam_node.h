#pragma once

#include <dynamic_reconfigure/server.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <kinect_ekf_slam/LoadMap.h>
#include <kinect_ekf_slam/SaveMap.h>
#include <kinect_ekf_slam/SetMode.h>
#include <kinect_ekf_slam/SlamConfig.h>
#include <nav_msgs/Path.h>
#include <ros/message_event.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <boost/thread/recursive_mutex.hpp>
#include <memory>
#include <string>

#include "kinect_ekf_slam/ros/bounded_landmarks.h"
#include "kinect_ekf_slam/ros/global_map_publisher.h"
#include "kinect_ekf_slam/ros/gradual_correction.h"
#include "kinect_ekf_slam/ros/health.h"
#include "kinect_ekf_slam/ros/markers.h"
#include "kinect_ekf_slam/ros/slam_session.h"
#include "kinect_ekf_slam/ros/trail.h"

namespace kinect_ekf_slam {

/// The live shell round a SlamSession: subscriptions in, topics, tf and services out. One thread.
class SlamNode {
 public:
  /// Throws std::runtime_error with one line when a map that should be loaded cannot be.
  SlamNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle, tf2_ros::Buffer* transforms,
           const RunOptions& options);

  /// Saves the map if map/save_at_exit.
  void shut_down();

 private:
  /// A message, and when it came.
  template <class Message>
  using Event = ros::MessageEvent<Message const>;

  void connect();
  /// Notices a clock that went back (simulated time), and starts anew then.
  ros::Time now();
  std::optional<Eigen::Isometry3d> base_from(const std::string& target, const std::string& source,
                                             const ros::Time& stamp);

  void on_odometry(const Event<nav_msgs::Odometry>& event);
  void on_imu(const Event<sensor_msgs::Imu>& event);
  void on_landmarks(const Event<BoundedLandmarks>& event);
  void on_position(const Event<geometry_msgs::PoseWithCovarianceStamped>& event);
  void on_fix(const Event<sensor_msgs::NavSatFix>& event);
  void on_ranges(const Event<BeaconRanges>& event);
  void on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped::ConstPtr& message);
  void on_result(const SensorFrame& frame, const SlamResult& result);
  void on_live_change(SlamConfig* config);

  bool save_map(SaveMap::Request& request, SaveMap::Response& response);
  bool load_map(LoadMap::Request& request, LoadMap::Response& response);
  bool reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool set_mode(SetMode::Request& request, SetMode::Response& response);
  bool relocalize(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  void forget_what_was_shown();
  /// The clock went back, or ~reset was called.
  void forget_run();
  void publish_pose(const nav_msgs::Odometry& odometry);
  void publish_transform(const Pose3d& pose, const geometry_msgs::Pose& odom_from_base);
  /// tf fusion/frame -> map, each time that it changes.
  void publish_alignment(const SlamResult& result);
  void publish_scene();
  /// Of a map in map/directory; "": map/file_name.
  std::string path_of(const std::string& file_name) const;
  /// Returns the path. Throws MapFileError.
  std::string save(const std::string& file_name);
  /// Returns the path and what was in the file. Throws MapFileError.
  std::string load(const std::string& file_name, bool keep_saved_pose);
  /// Saves map/file_name unasked, and returns its path; without a landmark it saves nothing and returns "":
  /// a map of an earlier run is worth more than none. Throws MapFileError.
  std::string save_unless_empty();
  void autosave();

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  tf2_ros::Buffer* transforms_;
  RunOptions options_;
  SlamSession session_;
  Health health_;
  MarkerPainter painter_;
  std::unique_ptr<GlobalMapPublisher> global_map_;  ///< if global_map/enabled
  Trail path_;
  Trail dead_reckoned_path_;
  GradualCorrection correction_;
  nav_msgs::Path path_message_;
  std::vector<DetectionOutcome> last_outcomes_;

  bool paused_ = false;
  bool finite_ = true;
  bool scene_changed_ = true;
  ros::Time last_now_;
  ros::Time last_transform_;
  std::map<std::string, ros::WallTime> unknown_since_;  ///< frames that tf did not know when last waited for

  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  ros::Publisher pose_publisher_;
  ros::Publisher odometry_publisher_;
  ros::Publisher path_publisher_;
  ros::Publisher map_publisher_;
  ros::Publisher marker_publisher_;
  ros::Publisher association_publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  bool is_aligned_ = false;
  ros::Timer scene_timer_;
  ros::WallTimer autosave_timer_;
  diagnostic_updater::Updater diagnostics_;
  ros::WallTimer diagnostics_timer_;
  boost::recursive_mutex live_mutex_;
  std::unique_ptr<dynamic_reconfigure::Server<SlamConfig>> live_;
};

}  // namespace kinect_ekf_slam
