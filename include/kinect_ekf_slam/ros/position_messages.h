#pragma once

#include <geometry_msgs/PoseWithCovariance.h>
#include <kinect_ekf_slam/BeaconRanges.h>
#include <sensor_msgs/NavSatFix.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/local_tangent_plane.h"
#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// What is wrong with a message, as a reason to count and a line to read.
struct MessageProblem {
  std::string reason;
  std::string detail;
};

/// The antenna's pose in the frame of the message. Its attitude is used where the covariance of all three
/// angles is positive and less than that of any angle at all; a yaw alone is used where roll and pitch are as
/// good as the ground is flat.
GlobalPosition to_position(const geometry_msgs::PoseWithCovariance& message,
                           const Eigen::Isometry3d& base_from_antenna);
std::optional<MessageProblem> problem_of(const geometry_msgs::PoseWithCovariance& message);

/// East, north and up of the plane's datum. `sigma` m where the message has no covariance of its own.
GlobalPosition to_position(const sensor_msgs::NavSatFix& message, const LocalTangentPlane& plane,
                           const Eigen::Isometry3d& base_from_antenna, double sigma);
/// `sigma` 0: a fix without a covariance cannot be used.
std::optional<MessageProblem> problem_of(const sensor_msgs::NavSatFix& message, double sigma);
/// A plane is no picture of the Earth: a fix more than 100 km from the datum cannot be used. `position` m in
/// the plane.
std::optional<MessageProblem> problem_of_distance(const Eigen::Vector3d& position);

/// The robot's pose as RViz gives it. Where the covariance is zero, RViz's own doubt stands: unknown is never
/// zero.
Pose3d to_initial_pose(const geometry_msgs::PoseWithCovariance& message);
std::optional<MessageProblem> problem_of_initial_pose(const geometry_msgs::PoseWithCovariance& message);

std::vector<BeaconRange> to_ranges(const BeaconRanges& message, const Eigen::Isometry3d& base_from_receiver);

}  // namespace kinect_ekf_slam
