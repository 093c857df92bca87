#pragma once

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Quaternion.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/Vector3.h>
#include <kinect_ekf_slam/AssociationArray.h>
#include <kinect_ekf_slam/LandmarkDetection.h>
#include <kinect_ekf_slam/LandmarkMap.h>
#include <ros/time.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

TimeNs to_time(const ros::Time& stamp);
/// Throws std::runtime_error for a time before the epoch, as ros::Time does.
ros::Time to_ros(TimeNs stamp);
/// s; negative when `end` is the earlier one. The difference of two ros::Time throws beyond 68 years.
double seconds_between(const ros::Time& begin, const ros::Time& end);

Eigen::Vector3d to_eigen(const geometry_msgs::Vector3& vector);
Eigen::Vector3d to_eigen(const geometry_msgs::Point& point);
/// The quaternion is normalised; it must not be zero.
Eigen::Isometry3d to_eigen(const geometry_msgs::Pose& pose);
Eigen::Isometry3d to_eigen(const geometry_msgs::Transform& transform);

/// A frame's name as tf2 has it: older nodes write a slash before it.
std::string without_slash(const std::string& frame_id);

/// True for a place that a robot can be at (finite, at most 1e9 m away on each axis) and a quaternion that
/// can be normalised.
bool is_pose(const geometry_msgs::Pose& message);

geometry_msgs::Vector3 to_vector(const Eigen::Vector3d& vector);
geometry_msgs::Point to_point(const Eigen::Vector3d& point);
geometry_msgs::Quaternion to_quaternion(const Eigen::Matrix3d& rotation);
geometry_msgs::Pose to_pose(const Eigen::Isometry3d& pose);
geometry_msgs::Transform to_transform(const Eigen::Isometry3d& transform);
geometry_msgs::PoseWithCovariance to_pose_with_covariance(const Pose3d& pose);

/// True for a frame that REP-103 calls optical: Z forward, X right, Y down.
bool is_optical(const std::string& frame_id);

/// `base_from_sensor` places the frame of the message in the base. The message's numbers may be anything.
Detection to_detection(const LandmarkDetection& message, const Eigen::Isometry3d& base_from_sensor,
                       bool sensor_is_optical);

LandmarkMap to_message(const std::vector<Landmark3d>& map, const std::string& frame_id, TimeNs stamp);
AssociationArray to_message(const std::vector<DetectionOutcome>& outcomes, const std::string& frame_id,
                            TimeNs stamp);

}  // namespace kinect_ekf_slam
