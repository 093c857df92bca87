#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <stdexcept>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/simulation/place_sensors.h"
#include "kinect_ekf_slam/simulation/rgbd_camera.h"
#include "kinect_ekf_slam/simulation/robot_pose.h"

namespace kinect_ekf_slam {

/// A standing cylinder; in a spatial world a ball.
struct WorldLandmark {
  int id = kNoId;     ///< not negative, unique
  std::string label;  ///< its colour
  /// m; of the axis, at the height that a detector reports
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double radius = 0.0;  ///< m
};

/// How the robot drives or flies.
struct DriveOptions {
  RobotPose world_from_start;
  std::vector<Eigen::Vector3d> waypoints_in_world;  ///< m; driven to in order; on the floor z is zero
  int loops = 1;                                    ///< times that the waypoints are driven through
  double standing_time = 2.0;                       ///< s at the start, for the gyro's bias to be found
  double max_speed = 0.2;                           ///< m/s
  double max_turn_rate = 1.0;                       ///< rad/s, about each axis
  double max_acceleration = 0.3;                    ///< m/s^2
  double max_turn_acceleration = 2.0;               ///< rad/s^2
  double robot_radius = 0.18;                       ///< m; so near it comes to walls and cylinders
};

/// Encoders of a differential drive. All errors are of what the wheels report; at rest they report rest.
/// The odometry of a robot that flies errs in the same way, and reads its roll and pitch as well as its yaw.
struct WheelOptions {
  double rate = 30.0;             ///< Hz of the odometry, and of the drive's control
  double separation = 0.23;       ///< m between the wheels
  double scale_sigma = 0.01;      ///< of each wheel's reading over its travel, drawn once a run
  double noise = 0.01;            ///< m/sqrt(m) of each wheel's travel
  double slips_per_minute = 1.0;  ///< of driving: for a while one wheel spins
  double slip_share = 0.3;        ///< so much faster than the floor passes
  double slip_time = 0.4;         ///< s
};

struct GyroOptions {
  double rate = 100.0;         ///< Hz
  double noise = 0.003;        ///< rad/s of one reading, each axis
  double scale_sigma = 0.015;  ///< of each axis' reading over its rate, drawn once a run
  double bias_sigma = 0.01;    ///< rad/s, each axis, drawn once a run
  double bias_walk = 2e-5;     ///< (rad/s)/sqrt(s)
  Eigen::Isometry3d base_from_imu = Eigen::Isometry3d::Identity();
};

/// A Kinect with a detector of cylinders behind it. Its noise is the report's: variance f(Z) on each optical
/// axis (models/sensor_model.h), times `noise_scale` squared.
struct KinectOptions {
  double rate = 10.0;               ///< Hz
  double field_of_view_deg = 57.0;  ///< horizontal, whole angle
  double vertical_field_of_view_deg = 43.0;
  double min_depth = 0.6;          ///< m
  double max_depth = 2.6;          ///< m
  double noise_scale = 1.0;        ///< on the standard deviation; 0: exact
  double radius_noise = 0.005;     ///< m
  double miss_rate = 0.05;         ///< share of sightings that are not reported
  double false_per_minute = 0.0;   ///< detections of what is not there
  double gross_error_rate = 0.0;   ///< share of detections that are far off
  double gross_error_size = 2.0;   ///< m along the floor, at most
  double wrong_label_rate = 0.0;   ///< share of detections with another landmark's colour
  bool reports_covariance = true;  ///< false: all zero, the consumer has a model
  bool reports_identity = true;    ///< the true landmark's id in every detection; for evaluations
  /// Optical axes: X right, Y down, Z forward.
  Eigen::Isometry3d base_from_optical = Eigen::Isometry3d::Identity();
};

/// An upright square with something printed on both sides.
struct WorldPanel {
  enum class Print { kBlotches, kFiducial };
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();  ///< m
  double facing_deg = 0.0;                                    ///< deg from the world's X
  double size = 0.3;  ///< m, of an edge; of a fiducial, of its black square
  Print print = Print::kBlotches;
  int id = 0;  ///< of the fiducial; of blotches, which pattern
};

/// The pictures that the Kinect takes, at the mounting of the sensor.
struct PictureOptions {
  double rate = 0.0;       ///< Hz; 0: none
  bool has_errors = true;  ///< false: exact
  RgbdCameraOptions camera;
};

/// A room with landmarks, and the robot that moves in it. The world's origin is a corner of the room; the
/// robot starts anywhere. The world is spatial when the robot's pose is: then it flies among balls.
struct World {
  /// m; the walls are x, y = 0 and x, y = size; in a spatial world z = size is the ceiling
  Eigen::Vector3d room_size = Eigen::Vector3d::Zero();
  double wall_height = 2.5;        ///< m, in pictures; in a spatial world the room's
  bool has_blotches = false;       ///< in pictures: on walls, floor and ceiling
  std::vector<WorldPanel> panels;  ///< in pictures
  std::vector<WorldLandmark> landmarks;
  DriveOptions drive;
  WheelOptions wheels;
  GyroOptions gyro;
  KinectOptions sensor;
  PictureOptions pictures;
  GpsOptions gps;
  BeaconOptions beacons;

  bool is_spatial() const { return drive.world_from_start.is_spatial(); }
};

/// One line that names the file, the key, the value given and what is allowed.
class WorldFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a world (config/worlds/room.yaml and room_3d.yaml explain the keys). Throws WorldFileError.
World read_world(const std::string& path);

/// The same from text; `name` stands for the file in errors.
World parse_world(const std::string& yaml, const std::string& name);

}  // namespace kinect_ekf_slam
