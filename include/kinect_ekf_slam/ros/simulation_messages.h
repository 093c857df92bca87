#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <kinect_ekf_slam/BeaconRanges.h>
#include <kinect_ekf_slam/LandmarkDetectionArray.h>
#include <kinect_ekf_slam/LandmarkMap.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

#include "kinect_ekf_slam/simulation/simulator.h"

namespace kinect_ekf_slam {

/// Topics of a simulated robot, besides those that sync/* names; relative.
namespace simulation_topics {
constexpr const char* kOdometry = "odom";
constexpr const char* kImu = "imu";
constexpr const char* kLandmarks = "landmarks";
constexpr const char* kTruePose = "ground_truth/pose";
constexpr const char* kTrueLandmarks = "ground_truth/landmarks";
constexpr const char* kPosition = "global_position";
constexpr const char* kRanges = "beacon_ranges";
constexpr const char* kCommand = "cmd_vel";
constexpr const char* kColour = "camera/rgb/image_rect_color";
constexpr const char* kDepth = "camera/depth_registered/image_raw";
constexpr const char* kCameraInfo = "camera/rgb/camera_info";
}  // namespace simulation_topics

/// Samples as a robot's messages: the same for a bag and for the live node.
///
/// Frames: odom -> base_footprint moves; imu_link, kinect_rgb_optical_frame, gps_link and range_link are
/// mounted on base_footprint, the latter two where the world has GPS and beacons.
/// The ground truth has the frame `map`, but is in world coordinates: a map that starts at the robot differs
/// from it by the robot's start, so comparing needs an alignment.
class SimulationMessages {
 public:
  /// `start` is the time of the sample with stamp zero.
  SimulationMessages(const World& world, TimeNs start) : world_(world), start_(start) {}

  ros::Time stamp(const Sample& sample) const;

  /// The sample must have odometry.
  nav_msgs::Odometry odometry(const Sample& sample) const;
  geometry_msgs::TransformStamped odom_from_base(const Sample& sample) const;
  /// The sample must have a gyro rate. Orientation and acceleration are marked as not measured.
  sensor_msgs::Imu imu(const Sample& sample) const;
  /// The sample must have sightings, perhaps none.
  LandmarkDetectionArray landmarks(const Sample& sample) const;

  /// The sample must have a position: of the antenna, in the frame `earth`, which is the world.
  geometry_msgs::PoseWithCovarianceStamped position(const Sample& sample) const;
  /// The sample must have ranges, perhaps none.
  BeaconRanges ranges(const Sample& sample) const;

  /// Of the sensor's landmarks and pictures.
  std_msgs::Header optical_header(const Sample& sample) const;

  geometry_msgs::PoseStamped true_pose(const Sample& sample) const;
  LandmarkMap true_landmarks() const;
  /// From base_footprint to the sensors.
  std::vector<geometry_msgs::TransformStamped> mountings() const;

  /// The true landmarks and walls for RViz, seen from the robot's start: they lie over an estimated map,
  /// whose origin that is.
  visualization_msgs::MarkerArray markers() const;

 private:
  World world_;
  TimeNs start_;
};

}  // namespace kinect_ekf_slam
