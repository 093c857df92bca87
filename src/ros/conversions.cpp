#include "kinect_ekf_slam/ros/conversions.h"

#include <algorithm>
#include <cmath>

namespace kinect_ekf_slam {
namespace {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Isometry3d isometry(const Eigen::Vector3d& translation, const geometry_msgs::Quaternion& q) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.translation() = translation;
  transform.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  return transform;
}

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

TimeNs to_time(const ros::Time& stamp) { return static_cast<TimeNs>(stamp.toNSec()); }

ros::Time to_ros(TimeNs stamp) {
  if (stamp < 0) throw std::runtime_error("a time before the epoch");
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp));
  return time;
}

double seconds_between(const ros::Time& begin, const ros::Time& end) {
  return to_seconds(to_time(end) - to_time(begin));
}

Eigen::Vector3d to_eigen(const geometry_msgs::Vector3& vector) { return {vector.x, vector.y, vector.z}; }
Eigen::Vector3d to_eigen(const geometry_msgs::Point& point) { return {point.x, point.y, point.z}; }
Eigen::Isometry3d to_eigen(const geometry_msgs::Pose& pose) {
  return isometry(to_eigen(pose.position), pose.orientation);
}
Eigen::Isometry3d to_eigen(const geometry_msgs::Transform& transform) {
  return isometry(to_eigen(transform.translation), transform.rotation);
}

std::string without_slash(const std::string& frame_id) {
  return !frame_id.empty() && frame_id.front() == '/' ? frame_id.substr(1) : frame_id;
}

bool is_pose(const geometry_msgs::Pose& message) {
  constexpr double kFarthest = 1e9;   // m
  constexpr double kShortest = 1e-6;  // a quaternion's norm; its square has to be a number as well
  constexpr double kLongest = 1e6;
  const auto& q = message.orientation;
  const double norm = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
  return (to_eigen(message.position).array().abs() <= kFarthest).all() && norm > kShortest && norm < kLongest;
}

geometry_msgs::Vector3 to_vector(const Eigen::Vector3d& vector) {
  geometry_msgs::Vector3 message;
  message.x = vector.x();
  message.y = vector.y();
  message.z = vector.z();
  return message;
}

geometry_msgs::Point to_point(const Eigen::Vector3d& point) {
  geometry_msgs::Point message;
  message.x = point.x();
  message.y = point.y();
  message.z = point.z();
  return message;
}

geometry_msgs::Quaternion to_quaternion(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond quaternion(rotation);
  geometry_msgs::Quaternion message;
  message.w = quaternion.w();
  message.x = quaternion.x();
  message.y = quaternion.y();
  message.z = quaternion.z();
  return message;
}

geometry_msgs::Pose to_pose(const Eigen::Isometry3d& pose) {
  geometry_msgs::Pose message;
  message.position = to_point(pose.translation());
  message.orientation = to_quaternion(pose.linear());
  return message;
}

geometry_msgs::Transform to_transform(const Eigen::Isometry3d& transform) {
  geometry_msgs::Transform message;
  message.translation = to_vector(transform.translation());
  message.rotation = to_quaternion(transform.linear());
  return message;
}

geometry_msgs::PoseWithCovariance to_pose_with_covariance(const Pose3d& pose) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = to_pose(pose.map_from_base);
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.covariance.data()) = pose.covariance;
  return message;
}

bool is_optical(const std::string& frame_id) {
  return ends_with(frame_id, "_optical_frame") || ends_with(frame_id, "_optical");
}

Detection to_detection(const LandmarkDetection& message, const Eigen::Isometry3d& base_from_sensor,
                       bool sensor_is_optical) {
  // Body axes (x forward, y left, z up) seen from optical ones (Z forward, X right, Y down).
  Eigen::Matrix3d sensor_from_optical = Eigen::Matrix3d::Identity();
  if (!sensor_is_optical) sensor_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;

  Detection detection;
  const Eigen::Vector3d position_in_sensor = to_eigen(message.position);
  const Eigen::Matrix3d rotation = base_from_sensor.linear();
  detection.position_in_base = base_from_sensor * position_in_sensor;
  detection.position_in_optical = sensor_from_optical.transpose() * position_in_sensor;
  detection.base_from_optical = rotation * sensor_from_optical;
  const Eigen::Map<const RowMajor3d> covariance(message.covariance.data());
  if (!covariance.isZero(0.0)) detection.covariance_in_base = rotation * covariance * rotation.transpose();
  detection.signature.source_id = message.id < 0 ? kNoId : message.id;
  detection.signature.label = message.label;
  detection.signature.radius = std::isfinite(message.radius) && message.radius > 0.0F ? message.radius : 0.0;
  const bool has_descriptor = std::all_of(message.descriptor.begin(), message.descriptor.end(),
                                          [](float number) { return std::isfinite(number); });
  if (has_descriptor) detection.signature.descriptor = message.descriptor;
  detection.score = message.score;
  return detection;
}

LandmarkMap to_message(const std::vector<Landmark3d>& map, const std::string& frame_id, TimeNs stamp) {
  LandmarkMap message;
  message.header.frame_id = frame_id;
  message.header.stamp = to_ros(stamp);
  for (const Landmark3d& landmark : map) {
    Landmark entry;
    entry.id = landmark.id;
    entry.source_id = landmark.source_id;
    entry.label = landmark.label;
    entry.position = to_point(landmark.position_in_map);
    Eigen::Map<RowMajor3d>(entry.covariance.data()) = landmark.covariance;
    entry.radius = static_cast<float>(landmark.radius);
    entry.observations = landmark.observations;
    entry.status = landmark.confirmed ? Landmark::CONFIRMED : Landmark::PROVISIONAL;
    message.landmarks.push_back(entry);
  }
  return message;
}

AssociationArray to_message(const std::vector<DetectionOutcome>& outcomes, const std::string& frame_id,
                            TimeNs stamp) {
  AssociationArray message;
  message.header.frame_id = frame_id;
  message.header.stamp = to_ros(stamp);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    Association association;
    association.detection = static_cast<std::uint32_t>(i);
    association.source_id = outcomes[i].source_id;
    association.verdict = to_string(outcomes[i].verdict);
    association.landmark = outcomes[i].landmark_id;
    association.nis = outcomes[i].nis;
    association.position = to_point(outcomes[i].position_in_map);
    message.associations.push_back(association);
  }
  return message;
}

}  // namespace kinect_ekf_slam
