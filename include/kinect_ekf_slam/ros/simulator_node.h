#pragma once

#include <geometry_msgs/Twist.h>
#include <image_transport/image_transport.h>
#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "kinect_ekf_slam/ros/simulation_messages.h"
#include "kinect_ekf_slam/simulation/simulator.h"
#include "kinect_ekf_slam/study/simulated_picture.h"

namespace kinect_ekf_slam {

/// Parameters of simulator_node, in its private namespace.
struct SimulatorNodeOptions {
  std::string world;                   ///< `world`: file; required
  std::uint64_t seed = 1;              ///< `seed`
  bool by_command = false;             ///< `drive`: waypoints or cmd_vel
  double duration = 0.0;               ///< `duration`: s after which the node ends; 0: never
  double rate_factor = 1.0;            ///< `rate_factor`: times real time; other than 1 needs publish_clock
  bool publish_clock = false;          ///< `publish_clock`: /clock, for nodes that run with use_sim_time
  std::optional<double> picture_rate;  ///< `picture_rate`: Hz; in the place of the world's camera/rate
};

/// Throws std::runtime_error with one line that names the parameter, its value and what is allowed.
SimulatorNodeOptions read_simulator_node_options(const ros::NodeHandle& private_handle);

/// A simulated robot on ROS topics, in real time.
///
/// Publishes odom, imu, landmarks, ground_truth/pose and (latched) ground_truth/landmarks, both in world
/// coordinates, tf odom -> base_footprint, the static mountings, and ~markers (latched): the true cylinders
/// seen from the robot's start, as an estimated map has them; global_position and beacon_ranges where the
/// world has GPS and beacons; and the Kinect's pictures where the world's camera takes any. Driven by cmd_vel
/// (geometry_msgs/Twist), it stops when no command came for half a second.
class SimulatorNode {
 public:
  /// Throws WorldFileError.
  SimulatorNode(ros::NodeHandle handle, ros::NodeHandle private_handle, const SimulatorNodeOptions& options);

 private:
  void on_tick();
  void on_command(const geometry_msgs::Twist& command);
  /// How far the simulation should be by now.
  TimeNs due() const;
  void advertise_pictures(const ros::NodeHandle& handle);
  void publish(const Sample& sample);
  void publish_picture(const Sample& sample);
  void publish_once();

  SimulatorNodeOptions options_;
  Simulator simulator_;
  SimulatedCamera camera_;
  ros::WallTime wall_start_;
  ros::Time start_;  ///< stamp of the first sample
  SimulationMessages messages_;
  Sample next_;
  TimeNs last_command_ = 0;
  bool arrived_ = false;

  ros::Publisher odometry_publisher_;
  ros::Publisher imu_publisher_;
  ros::Publisher landmarks_publisher_;
  ros::Publisher position_publisher_;
  ros::Publisher ranges_publisher_;
  std::deque<geometry_msgs::PoseWithCovarianceStamped> delayed_positions_;
  ros::Publisher true_pose_publisher_;
  ros::Publisher true_landmarks_publisher_;
  ros::Publisher markers_publisher_;
  ros::Publisher clock_publisher_;
  image_transport::Publisher colour_publisher_;
  image_transport::Publisher depth_publisher_;
  ros::Publisher info_publisher_;
  ros::Subscriber command_subscriber_;
  tf2_ros::TransformBroadcaster transform_broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  ros::WallTimer timer_;
};

}  // namespace kinect_ekf_slam
