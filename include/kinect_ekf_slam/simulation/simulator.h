#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/simulation/waypoint_driver.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// One landmark as the simulated detector reports it, in the sensor's optical axes.
struct Sighting {
  Eigen::Vector3d position_in_optical = Eigen::Vector3d::Zero();    ///< m
  Eigen::Matrix3d covariance_in_optical = Eigen::Matrix3d::Zero();  ///< m^2; zero: not reported
  std::string label;
  double radius = 0.0;  ///< m
  double score = 1.0;
  int id = kNoId;  ///< the true landmark; kNoId: there is none, or sensor/reports_identity is off
};

/// What the wheels, or what a flying robot has instead, say of its way.
struct Odometry {
  Eigen::Isometry3d odom_from_base = Eigen::Isometry3d::Identity();
  BodyVelocity velocity;  ///< mean since the last odometry, in the base's axes
};

/// What is to be had at one time: the truth, and the readings of the sensors that are due.
struct Sample {
  TimeNs stamp = 0;  ///< from the start of the run
  Eigen::Isometry3d world_from_base = Eigen::Isometry3d::Identity();
  std::optional<Odometry> odometry;
  std::optional<Eigen::Vector3d> gyro_rate_in_imu;  ///< rad/s
  std::optional<std::vector<Sighting>> sightings;   ///< empty: looked, saw nothing
  std::optional<GlobalPosition> position;           ///< in the world
  std::optional<std::vector<BeaconRange>> ranges;   ///< empty: no beacon is near
  bool takes_picture = false;                       ///< the camera's turn: study/simulated_picture.h
};

/// The sighting as the estimators take it.
Detection to_detection(const Sighting& sighting, const Eigen::Isometry3d& base_from_optical);

/// A robot that drives or flies in a world, and its sensors. The same world and seed give the same samples.
class Simulator {
 public:
  Simulator(const World& world, std::uint64_t seed);

  /// Goes on to the next time at which a sensor is due. Samples come in the order of their stamps.
  Sample next();

  /// Takes the wheel from the waypoints: the robot strives for this velocity (forward and turning, about all
  /// axes where it flies) from now on.
  void set_command(const BodyVelocity& velocity) { command_ = velocity; }

  /// Stands at the last waypoint. Never so while it is driven by commands.
  bool finished() const;

  const World& world() const { return world_; }

 private:
  /// When something that happens at a steady rate is next due.
  struct Ticker {
    double rate;  ///< Hz; 0: never
    std::int64_t count = 0;
    TimeNs due() const {
      constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();
      return rate > 0.0 ? to_nanoseconds(static_cast<double>(count) / rate) : kNever;
    }
    bool take(TimeNs stamp) { return due() == stamp && ++count > 0; }
  };

  void advance(TimeNs stamp);
  void choose_velocity();
  bool is_free(const Eigen::Vector3d& position_in_world) const;
  Eigen::Vector3d from_landmark(const WorldLandmark& landmark,
                                const Eigen::Vector3d& position_in_world) const;
  Odometry read_odometry();
  double read_wheel(int wheel, double travel);
  double read_tilt(double tilt);
  Eigen::Vector3d read_gyro();
  std::vector<Sighting> look();
  std::optional<Sighting> see(const WorldLandmark& landmark, const Eigen::Isometry3d& world_from_optical);
  bool is_hidden(const WorldLandmark& landmark, const Eigen::Vector3d& sensor_in_world) const;
  Sighting imagine();
  std::string other_label(const std::string& label);

  World world_;
  std::vector<std::string> labels_;  ///< all that occur, each once
  WaypointDriver driver_;
  std::optional<BodyVelocity> command_;
  RandomStream wheel_random_;
  RandomStream gyro_random_;
  RandomStream sensor_random_;
  GpsReceiver gps_;
  RangeReceiver range_receiver_;
  Ticker odometry_ticker_;
  Ticker gyro_ticker_;
  Ticker sensor_ticker_;
  Ticker camera_ticker_;
  Ticker gps_ticker_;
  Ticker range_ticker_;

  TimeNs now_ = 0;
  RobotPose world_from_base_;
  BodyVelocity velocity_;  ///< true, held until the next odometry
  RobotPose odom_from_base_;
  TimeNs last_odometry_ = 0;
  Eigen::Vector2d travel_ = Eigen::Vector2d::Zero();  ///< m of the left and right wheel since then
  Eigen::Vector2d tilt_ = Eigen::Vector2d::Zero();    ///< rad of roll and pitch since then
  Eigen::Vector2d wheel_scale_;
  int slipping_wheel_ = 0;
  TimeNs slip_end_ = 0;
  Eigen::Vector3d gyro_scale_;
  Eigen::Vector3d gyro_bias_in_imu_;  ///< rad/s
  double gyro_bias_time_ = 0.0;       ///< s until which the bias has walked
};

}  // namespace kinect_ekf_slam
