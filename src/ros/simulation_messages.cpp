#include "kinect_ekf_slam/ros/simulation_messages.h"

#include <array>

#include "kinect_ekf_slam/ros/conversions.h"
#include "kinect_ekf_slam/ros/markers.h"

namespace kinect_ekf_slam {
namespace {

constexpr const char* kMapFrame = "map";
constexpr const char* kOdomFrame = "odom";
constexpr const char* kBaseFrame = "base_footprint";
constexpr const char* kImuFrame = "imu_link";
constexpr const char* kOpticalFrame = "kinect_rgb_optical_frame";

// Variances of odometry as a TurtleBot's driver states them: rough, and large where a wheel measures nothing.
constexpr double kPlaneVariance = 1e-3;    // m^2, (m/s)^2
constexpr double kHeadingVariance = 1e-2;  // rad^2, (rad/s)^2
constexpr double kNotMeasured = 1e6;

constexpr double kAxisHeightShare = 2.0;  // a cylinder's height over that of its detected centre
constexpr float kOpacity = 0.35F;
constexpr double kWallWidth = 0.03;  // m

template <class Array>
void set_variances(Array* covariance) {
  constexpr std::array<double, 6> kVariances = {kPlaneVariance, kPlaneVariance, kNotMeasured,
                                                kNotMeasured,   kNotMeasured,   kHeadingVariance};
  for (std::size_t i = 0; i < kVariances.size(); ++i)
    (*covariance)[i * (kVariances.size() + 1)] = kVariances[i];
}

geometry_msgs::TransformStamped mounting(const Eigen::Isometry3d& base_from_sensor, const char* sensor_frame,
                                         const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = kBaseFrame;
  message.child_frame_id = sensor_frame;
  message.transform = to_transform(base_from_sensor);
  return message;
}

LandmarkDetection to_message(const Sighting& sighting) {
  LandmarkDetection message;
  message.id = sighting.id;
  message.label = sighting.label;
  message.position = to_point(sighting.position_in_optical);
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(message.covariance.data()) =
      sighting.covariance_in_optical;
  message.radius = static_cast<float>(sighting.radius);
  message.score = static_cast<float>(sighting.score);
  return message;
}

visualization_msgs::Marker wall_marker(const Eigen::Vector2d& room_size, const Se2& start_from_world) {
  visualization_msgs::Marker marker;
  marker.ns = "true_walls";
  marker.type = visualization_msgs::Marker::LINE_STRIP;
  marker.scale.x = kWallWidth;
  marker.color = label_color("");
  marker.pose.orientation.w = 1.0;
  for (const auto& [x, y] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.0, 0.0}}) {
    const Eigen::Vector2d corner = room_size.cwiseProduct(Eigen::Vector2d(x, y));
    marker.points.push_back(to_point(Planar::to_3d(Planar::Point(start_from_world * corner))));
  }
  return marker;
}

visualization_msgs::Marker cylinder_marker(const WorldLandmark& landmark, const Se2& start_from_world) {
  visualization_msgs::Marker marker;
  marker.ns = "true_landmarks";
  marker.id = landmark.id;
  marker.type = visualization_msgs::Marker::CYLINDER;
  marker.pose.position = to_point(Planar::to_3d(start_from_world) * landmark.position_in_world);
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = 2.0 * landmark.radius;
  marker.scale.z = kAxisHeightShare * std::max(landmark.position_in_world.z(), landmark.radius);
  marker.color = label_color(landmark.label);
  marker.color.a = kOpacity;
  return marker;
}

}  // namespace

ros::Time SimulationMessages::stamp(const Sample& sample) const { return to_ros(start_ + sample.stamp); }

nav_msgs::Odometry SimulationMessages::odometry(const Sample& sample) const {
  nav_msgs::Odometry message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kOdomFrame;
  message.child_frame_id = kBaseFrame;
  message.pose.pose = to_pose(Planar::to_3d(sample.odometry->odom_from_base));
  message.twist.twist.linear.x = sample.odometry->velocity.linear.x();
  message.twist.twist.angular.z = sample.odometry->velocity.angular.z();
  set_variances(&message.pose.covariance);
  set_variances(&message.twist.covariance);
  return message;
}

geometry_msgs::TransformStamped SimulationMessages::odom_from_base(const Sample& sample) const {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kOdomFrame;
  message.child_frame_id = kBaseFrame;
  message.transform = to_transform(Planar::to_3d(sample.odometry->odom_from_base));
  return message;
}

sensor_msgs::Imu SimulationMessages::imu(const Sample& sample) const {
  sensor_msgs::Imu message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kImuFrame;
  message.angular_velocity.x = sample.gyro_rate_in_imu->x();
  message.angular_velocity.y = sample.gyro_rate_in_imu->y();
  message.angular_velocity.z = sample.gyro_rate_in_imu->z();
  const double variance = world_.gyro.noise * world_.gyro.noise;
  for (const std::size_t i : {0U, 4U, 8U}) message.angular_velocity_covariance[i] = variance;
  message.orientation.w = 1.0;
  message.orientation_covariance[0] = -1.0;
  message.linear_acceleration_covariance[0] = -1.0;
  return message;
}

LandmarkDetectionArray SimulationMessages::landmarks(const Sample& sample) const {
  LandmarkDetectionArray message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kOpticalFrame;
  for (const Sighting& sighting : *sample.sightings) message.detections.push_back(to_message(sighting));
  return message;
}

geometry_msgs::PoseStamped SimulationMessages::true_pose(const Sample& sample) const {
  geometry_msgs::PoseStamped message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kMapFrame;
  message.pose = to_pose(Planar::to_3d(sample.world_from_base));
  return message;
}

LandmarkMap SimulationMessages::true_landmarks() const {
  LandmarkMap message;
  message.header.stamp = to_ros(start_);
  message.header.frame_id = kMapFrame;
  for (const WorldLandmark& landmark : world_.landmarks) {
    Landmark entry;
    entry.id = landmark.id;
    entry.source_id = landmark.id;
    entry.label = landmark.label;
    entry.position = to_point(landmark.position_in_world);
    entry.radius = static_cast<float>(landmark.radius);
    entry.status = Landmark::CONFIRMED;
    message.landmarks.push_back(entry);
  }
  return message;
}

std::vector<geometry_msgs::TransformStamped> SimulationMessages::mountings() const {
  return {mounting(world_.gyro.base_from_imu, kImuFrame, to_ros(start_)),
          mounting(world_.sensor.base_from_optical, kOpticalFrame, to_ros(start_))};
}

visualization_msgs::MarkerArray SimulationMessages::markers() const {
  const Se2 start_from_world = world_.drive.world_from_start.inverse();
  visualization_msgs::MarkerArray array;
  array.markers.push_back(wall_marker(world_.room_size, start_from_world));
  for (const WorldLandmark& landmark : world_.landmarks) {
    array.markers.push_back(cylinder_marker(landmark, start_from_world));
  }
  for (visualization_msgs::Marker& marker : array.markers) {
    marker.header.frame_id = kMapFrame;
    marker.header.stamp = to_ros(start_);
  }
  return array;
}

}  // namespace kinect_ekf_slam
