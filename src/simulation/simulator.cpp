#include "kinect_ekf_slam/simulation/simulator.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/models/sensor_model.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kMinute = 60.0;  // s

enum Stream : std::uint32_t { kWheelStream, kGyroStream, kSensorStream, kGpsStream, kRangeStream };

Eigen::Vector3d normal_vector(RandomStream& random) {
  const double x = random.normal();  // one after the other: the order of arguments is not defined
  const double y = random.normal();
  const double z = random.normal();
  return {x, y, z};
}

double approach(double present, double wanted, double largest_change) {
  return present + std::clamp(wanted - present, -largest_change, largest_change);
}

BodyVelocity scaled(const BodyVelocity& velocity, double factor) {
  return {factor * velocity.linear, factor * velocity.angular, {}};
}

/// Half the width and height of the view at a depth of 1 m.
Eigen::Vector2d view_edge(const KinectOptions& sensor) {
  return {std::tan(0.5 * radians(sensor.field_of_view_deg)),
          std::tan(0.5 * radians(sensor.vertical_field_of_view_deg))};
}

std::vector<std::string> labels_of(const std::vector<WorldLandmark>& landmarks) {
  std::vector<std::string> labels;
  labels.reserve(landmarks.size());
  for (const WorldLandmark& landmark : landmarks) labels.push_back(landmark.label);
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  return labels;
}

/// The report's noise for a cylinder seen there, m^2: one formula for the simulation and the estimate.
Eigen::Matrix3d report_covariance(const Eigen::Vector3d& position_in_optical) {
  Detection detection;
  detection.position_in_optical = position_in_optical;
  return with_noise(detection, SensorOptions())
      .covariance_in_base;  // base and optical axes taken for the same
}

}  // namespace

Detection to_detection(const Sighting& sighting, const Eigen::Isometry3d& base_from_optical) {
  Detection detection;
  detection.position_in_optical = sighting.position_in_optical;
  detection.base_from_optical = base_from_optical.linear();
  detection.position_in_base = base_from_optical * sighting.position_in_optical;
  detection.covariance_in_base =
      detection.base_from_optical * sighting.covariance_in_optical * detection.base_from_optical.transpose();
  detection.signature.source_id = sighting.id;
  detection.signature.label = sighting.label;
  detection.signature.radius = sighting.radius;
  detection.score = sighting.score;
  return detection;
}

Simulator::Simulator(const World& world, std::uint64_t seed)
    : world_(world),
      labels_(labels_of(world.landmarks)),
      driver_(world.drive),
      wheel_random_(seed, kWheelStream),
      gyro_random_(seed, kGyroStream),
      sensor_random_(seed, kSensorStream),
      gps_(world.gps, RandomStream(seed, kGpsStream)),
      range_receiver_(world.beacons, RandomStream(seed, kRangeStream)),
      odometry_ticker_{world.wheels.rate},
      gyro_ticker_{world.gyro.rate},
      sensor_ticker_{world.sensor.rate},
      camera_ticker_{world.pictures.rate},
      gps_ticker_{world.gps.rate},
      range_ticker_{world.beacons.rate},
      world_from_base_(world.drive.world_from_start),
      odom_from_base_(world.is_spatial() ? RobotPose(Se3()) : RobotPose(Se2())) {
  for (double& scale : wheel_scale_) scale = 1.0 + world.wheels.scale_sigma * wheel_random_.normal();
  gyro_scale_ = Eigen::Vector3d::Ones() + world.gyro.scale_sigma * normal_vector(gyro_random_);
  gyro_bias_in_imu_ = world.gyro.bias_sigma * normal_vector(gyro_random_);
}

Sample Simulator::next() {
  advance(std::min({odometry_ticker_.due(), gyro_ticker_.due(), sensor_ticker_.due(), camera_ticker_.due(),
                    gps_ticker_.due(), range_ticker_.due()}));
  Sample sample;
  sample.stamp = now_;
  sample.world_from_base = world_from_base_.to_3d();
  if (gyro_ticker_.take(now_)) sample.gyro_rate_in_imu = read_gyro();
  if (sensor_ticker_.take(now_)) sample.sightings = look();
  if (gps_ticker_.take(now_)) sample.position = gps_.read(now_, sample.world_from_base);
  if (range_ticker_.take(now_)) sample.ranges = range_receiver_.read(sample.world_from_base);
  sample.takes_picture = camera_ticker_.take(now_);
  if (odometry_ticker_.take(now_)) {
    sample.odometry = read_odometry();
    choose_velocity();
  }
  return sample;
}

bool Simulator::finished() const {
  return !command_ && driver_.done() && velocity_.linear.isZero(0.0) && velocity_.angular.isZero(0.0);
}

void Simulator::advance(TimeNs stamp) {
  const BodyVelocity way = scaled(velocity_, to_seconds(stamp - now_));
  world_from_base_.move(way);
  const double forward = way.linear.x();
  const double difference = 0.5 * world_.wheels.separation * way.angular.z();
  travel_ += Eigen::Vector2d(forward - difference, forward + difference);
  tilt_ += way.angular.head<2>();
  now_ = stamp;
}

/// The velocity of the next control period: what is wanted, as far as motors, walls and cylinders allow.
void Simulator::choose_velocity() {
  const DriveOptions& drive = world_.drive;
  const double period = 1.0 / world_.wheels.rate;
  const BodyVelocity wanted = command_ ? *command_ : driver_.command(now_, world_from_base_.to_3d());
  const double speed = std::clamp(wanted.linear.x(), -drive.max_speed, drive.max_speed);
  velocity_.linear.x() = approach(velocity_.linear.x(), speed, drive.max_acceleration * period);
  for (int axis = world_.is_spatial() ? 0 : 2; axis < 3; ++axis) {
    const double rate = std::clamp(wanted.angular(axis), -drive.max_turn_rate, drive.max_turn_rate);
    velocity_.angular(axis) = approach(velocity_.angular(axis), rate, drive.max_turn_acceleration * period);
  }
  RobotPose next = world_from_base_;
  next.move(scaled(velocity_, period));
  if (!is_free(next.to_3d().translation())) velocity_.linear.x() = 0.0;
}

bool Simulator::is_free(const Eigen::Vector3d& position_in_world) const {
  const double radius = world_.drive.robot_radius;
  const int axes = world_.is_spatial() ? 3 : 2;
  const auto position = position_in_world.head(axes).array();
  if ((position < radius).any() || (position > world_.room_size.head(axes).array() - radius).any()) {
    return false;
  }
  return std::none_of(world_.landmarks.begin(), world_.landmarks.end(), [&](const WorldLandmark& landmark) {
    return from_landmark(landmark, position_in_world).norm() < radius + landmark.radius;
  });
}

/// From the centre of a ball; from the axis of a cylinder, which stands through all heights.
Eigen::Vector3d Simulator::from_landmark(const WorldLandmark& landmark,
                                         const Eigen::Vector3d& position_in_world) const {
  Eigen::Vector3d offset = position_in_world - landmark.position_in_world;
  if (!world_.is_spatial()) offset.z() = 0.0;
  return offset;
}

Odometry Simulator::read_odometry() {
  const double dt = to_seconds(now_ - last_odometry_);
  const bool moved = !travel_.isZero(0.0);
  if (moved && now_ >= slip_end_ && wheel_random_.chance(world_.wheels.slips_per_minute * dt / kMinute)) {
    slipping_wheel_ = static_cast<int>(wheel_random_.index(2));
    slip_end_ = now_ + to_nanoseconds(world_.wheels.slip_time);
  }
  const double left = read_wheel(0, travel_(0));
  const double right = read_wheel(1, travel_(1));
  BodyVelocity way;
  way.linear.x() = 0.5 * (left + right);
  way.angular.z() = (right - left) / world_.wheels.separation;
  if (world_.is_spatial()) {
    way.angular.x() = read_tilt(tilt_(0));
    way.angular.y() = read_tilt(tilt_(1));
  }
  travel_.setZero();
  tilt_.setZero();
  last_odometry_ = now_;
  odom_from_base_.move(way);
  Odometry odometry{odom_from_base_.to_3d(), {}};
  if (dt > 0.0) odometry.velocity = {way.linear / dt, way.angular / dt, {}};
  return odometry;
}

double Simulator::read_wheel(int wheel, double travel) {
  const double slip = now_ < slip_end_ && wheel == slipping_wheel_ ? world_.wheels.slip_share : 0.0;
  const double noise = world_.wheels.noise * std::sqrt(std::abs(travel)) * wheel_random_.normal();
  return wheel_scale_(wheel) * (1.0 + slip) * travel + noise;
}

/// The noise of a turn that two wheels read, for their way and for that of the tilt itself.
double Simulator::read_tilt(double tilt) {
  const double separation = world_.wheels.separation;
  const double way = travel_.cwiseAbs().sum() + separation * std::abs(tilt);
  return tilt + world_.wheels.noise * std::sqrt(way) / separation * wheel_random_.normal();
}

Eigen::Vector3d Simulator::read_gyro() {
  const double dt = to_seconds(now_) - gyro_bias_time_;
  gyro_bias_time_ = to_seconds(now_);
  gyro_bias_in_imu_ += world_.gyro.bias_walk * std::sqrt(dt) * normal_vector(gyro_random_);
  const Eigen::Vector3d rate_in_imu = world_.gyro.base_from_imu.linear().transpose() * velocity_.angular;
  return gyro_scale_.cwiseProduct(rate_in_imu) + gyro_bias_in_imu_ +
         world_.gyro.noise * normal_vector(gyro_random_);
}

std::vector<Sighting> Simulator::look() {
  const Eigen::Isometry3d world_from_optical = world_from_base_.to_3d() * world_.sensor.base_from_optical;
  std::vector<Sighting> sightings;
  for (const WorldLandmark& landmark : world_.landmarks) {
    if (auto sighting = see(landmark, world_from_optical)) sightings.push_back(std::move(*sighting));
  }
  if (sensor_random_.chance(world_.sensor.false_per_minute / (kMinute * world_.sensor.rate))) {
    sightings.push_back(imagine());
  }
  return sightings;
}

std::optional<Sighting> Simulator::see(const WorldLandmark& landmark,
                                       const Eigen::Isometry3d& world_from_optical) {
  const KinectOptions& sensor = world_.sensor;
  const Eigen::Vector3d position = world_from_optical.inverse() * landmark.position_in_world;
  const Eigen::Vector2d edge = view_edge(sensor);
  const bool in_view = position.z() >= sensor.min_depth && position.z() <= sensor.max_depth &&
                       std::abs(position.x()) <= edge.x() * position.z() &&
                       std::abs(position.y()) <= edge.y() * position.z();
  if (!in_view || is_hidden(landmark, world_from_optical.translation())) return std::nullopt;
  if (sensor_random_.chance(sensor.miss_rate)) return std::nullopt;

  const Eigen::Matrix3d covariance = sensor.noise_scale * sensor.noise_scale * report_covariance(position);
  Sighting sighting;
  sighting.position_in_optical =
      position + covariance.diagonal().cwiseSqrt().cwiseProduct(normal_vector(sensor_random_));
  if (sensor.reports_covariance) sighting.covariance_in_optical = covariance;
  sighting.radius = std::max(0.001, landmark.radius + sensor.radius_noise * sensor_random_.normal());
  sighting.score = sensor_random_.uniform(0.6, 1.0);
  sighting.label = landmark.label;
  if (sensor.reports_identity) sighting.id = landmark.id;
  if (sensor_random_.chance(sensor.gross_error_rate)) {
    const double size = sensor_random_.uniform(0.0, sensor.gross_error_size);
    const double direction = sensor_random_.uniform(-kPi, kPi);
    sighting.position_in_optical += size * Eigen::Vector3d(std::sin(direction), 0.0, std::cos(direction));
  }
  if (sensor_random_.chance(sensor.wrong_label_rate)) sighting.label = other_label(landmark.label);
  return sighting;
}

/// True when the line of sight to the landmark's axis or centre goes through another one.
bool Simulator::is_hidden(const WorldLandmark& landmark, const Eigen::Vector3d& sensor_in_world) const {
  const Eigen::Vector3d sight = -from_landmark(landmark, sensor_in_world);
  const double distance = sight.norm();
  return std::any_of(world_.landmarks.begin(), world_.landmarks.end(), [&](const WorldLandmark& other) {
    const Eigen::Vector3d to_other = -from_landmark(other, sensor_in_world);
    const double along = sight.dot(to_other) / distance;
    const double aside = sight.cross(to_other).norm() / distance;
    return other.id != landmark.id && along > 0.0 && along < distance && aside < other.radius;
  });
}

/// A detection of what is not there, anywhere in view.
Sighting Simulator::imagine() {
  const KinectOptions& sensor = world_.sensor;
  const Eigen::Vector2d edge = view_edge(sensor);
  Sighting sighting;
  const double depth = sensor_random_.uniform(sensor.min_depth, sensor.max_depth);
  const double right = depth * sensor_random_.uniform(-edge.x(), edge.x());
  const double down = world_.is_spatial() ? depth * sensor_random_.uniform(-edge.y(), edge.y()) : 0.0;
  sighting.position_in_optical = Eigen::Vector3d(right, down, depth);
  if (sensor.reports_covariance) {
    sighting.covariance_in_optical =
        sensor.noise_scale * sensor.noise_scale * report_covariance(sighting.position_in_optical);
  }
  if (!labels_.empty()) sighting.label = labels_[sensor_random_.index(labels_.size())];
  sighting.radius = sensor_random_.uniform(0.03, 0.12);
  sighting.score = sensor_random_.uniform(0.3, 0.8);
  return sighting;
}

std::string Simulator::other_label(const std::string& label) {
  if (labels_.size() < 2) return label;
  const auto own = std::lower_bound(labels_.begin(), labels_.end(), label) - labels_.begin();
  return labels_[(static_cast<std::size_t>(own) + 1 + sensor_random_.index(labels_.size() - 1)) %
                 labels_.size()];
}

}  // namespace kinect_ekf_slam
