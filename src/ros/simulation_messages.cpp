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
constexpr const char* kEarthFrame = "earth";
constexpr const char* kGpsFrame = "gps_link";
constexpr const char* kRangeFrame = "range_link";
constexpr const char* kOpticalFrame = "kinect_rgb_optical_frame";

// Variances of odometry as a TurtleBot's driver states them: rough, and large where a wheel measures nothing.
constexpr double kPlaneVariance = 1e-3;    // m^2, (m/s)^2
constexpr double kHeadingVariance = 1e-2;  // rad^2, (rad/s)^2
constexpr double kNotMeasured = 1e6;

constexpr double kAxisHeightShare = 2.0;  // a cylinder's height over that of its detected centre
constexpr float kOpacity = 0.35F;
constexpr double kWallWidth = 0.03;  // m

template <class Array>
void set_variances(bool spatial, Array* covariance) {
  const double height = spatial ? kPlaneVariance : kNotMeasured;
  const double tilt = spatial ? kHeadingVariance : kNotMeasured;
  const std::array<double, 6> variances = {kPlaneVariance, kPlaneVariance, height,
                                           tilt,           tilt,           kHeadingVariance};
  for (std::size_t i = 0; i < variances.size(); ++i) (*covariance)[i * (variances.size() + 1)] = variances[i];
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

/// Where the walls meet the floor, or a plane above it.
visualization_msgs::Marker wall_marker(const Eigen::Vector3d& room_size, double height, int id,
                                       const Eigen::Isometry3d& start_from_world) {
  visualization_msgs::Marker marker;
  marker.ns = "true_walls";
  marker.id = id;
  marker.type = visualization_msgs::Marker::LINE_STRIP;
  marker.scale.x = kWallWidth;
  marker.color = label_color("");
  marker.pose.orientation.w = 1.0;
  for (const auto& [x, y] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.0, 0.0}}) {
    const Eigen::Vector3d corner(x * room_size.x(), y * room_size.y(), height);
    marker.points.push_back(to_point(start_from_world * corner));
  }
  return marker;
}

visualization_msgs::Marker landmark_marker(const WorldLandmark& landmark, bool spatial,
                                           const Eigen::Isometry3d& start_from_world) {
  visualization_msgs::Marker marker;
  marker.ns = "true_landmarks";
  marker.id = landmark.id;
  marker.type = spatial ? visualization_msgs::Marker::SPHERE : visualization_msgs::Marker::CYLINDER;
  marker.pose.position = to_point(start_from_world * landmark.position_in_world);
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 2.0 * landmark.radius;
  if (!spatial) marker.scale.z = kAxisHeightShare * std::max(landmark.position_in_world.z(), landmark.radius);
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
  message.pose.pose = to_pose(sample.odometry->odom_from_base);
  message.twist.twist.linear = to_vector(sample.odometry->velocity.linear);
  message.twist.twist.angular = to_vector(sample.odometry->velocity.angular);
  set_variances(world_.is_spatial(), &message.pose.covariance);
  set_variances(world_.is_spatial(), &message.twist.covariance);
  return message;
}

geometry_msgs::TransformStamped SimulationMessages::odom_from_base(const Sample& sample) const {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kOdomFrame;
  message.child_frame_id = kBaseFrame;
  message.transform = to_transform(sample.odometry->odom_from_base);
  return message;
}

sensor_msgs::Imu SimulationMessages::imu(const Sample& sample) const {
  sensor_msgs::Imu message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kImuFrame;
  message.angular_velocity = to_vector(*sample.gyro_rate_in_imu);
  const double variance = world_.gyro.noise * world_.gyro.noise;
  for (const std::size_t i : {0U, 4U, 8U}) message.angular_velocity_covariance[i] = variance;
  message.orientation.w = 1.0;
  message.orientation_covariance[0] = -1.0;
  message.linear_acceleration_covariance[0] = -1.0;
  return message;
}

LandmarkDetectionArray SimulationMessages::landmarks(const Sample& sample) const {
  LandmarkDetectionArray message;
  message.header = optical_header(sample);
  for (const Sighting& sighting : *sample.sightings) message.detections.push_back(to_message(sighting));
  return message;
}

geometry_msgs::PoseWithCovarianceStamped SimulationMessages::position(const Sample& sample) const {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kEarthFrame;
  message.pose.pose.position = to_point(sample.position->position_in_map);
  message.pose.pose.orientation.w = 1.0;
  Eigen::Matrix<double, 6, 6> covariance = sample.position->covariance;
  covariance.diagonal().tail<3>().setConstant(kNotMeasured);
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.pose.covariance.data()) = covariance;
  return message;
}

BeaconRanges SimulationMessages::ranges(const Sample& sample) const {
  BeaconRanges message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kRangeFrame;
  for (const BeaconRange& range : *sample.ranges) {
    message.ranges.emplace_back();
    message.ranges.back().beacon = range.beacon;
    message.ranges.back().range = range.range;
    message.ranges.back().variance = range.variance;
  }
  return message;
}

std_msgs::Header SimulationMessages::optical_header(const Sample& sample) const {
  std_msgs::Header header;
  header.stamp = stamp(sample);
  header.frame_id = kOpticalFrame;
  return header;
}

geometry_msgs::PoseStamped SimulationMessages::true_pose(const Sample& sample) const {
  geometry_msgs::PoseStamped message;
  message.header.stamp = stamp(sample);
  message.header.frame_id = kMapFrame;
  message.pose = to_pose(sample.world_from_base);
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
  std::vector<geometry_msgs::TransformStamped> mountings = {
      mounting(world_.gyro.base_from_imu, kImuFrame, to_ros(start_)),
      mounting(world_.sensor.base_from_optical, kOpticalFrame, to_ros(start_))};
  const auto at = [](const Eigen::Vector3d& place) { return Eigen::Isometry3d(Eigen::Translation3d(place)); };
  if (world_.gps.rate > 0.0) {
    mountings.push_back(mounting(at(world_.gps.antenna_in_base), kGpsFrame, to_ros(start_)));
  }
  if (world_.beacons.rate > 0.0) {
    mountings.push_back(mounting(at(world_.beacons.receiver_in_base), kRangeFrame, to_ros(start_)));
  }
  return mountings;
}

visualization_msgs::MarkerArray SimulationMessages::markers() const {
  const Eigen::Isometry3d start_from_world = world_.drive.world_from_start.to_3d().inverse();
  visualization_msgs::MarkerArray array;
  array.markers.push_back(wall_marker(world_.room_size, 0.0, 0, start_from_world));
  if (world_.is_spatial()) {
    array.markers.push_back(wall_marker(world_.room_size, world_.room_size.z(), 1, start_from_world));
  }
  for (const WorldLandmark& landmark : world_.landmarks) {
    array.markers.push_back(landmark_marker(landmark, world_.is_spatial(), start_from_world));
  }
  for (visualization_msgs::Marker& marker : array.markers) {
    marker.header.frame_id = kMapFrame;
    marker.header.stamp = to_ros(start_);
  }
  return array;
}

}  // namespace kinect_ekf_slam
