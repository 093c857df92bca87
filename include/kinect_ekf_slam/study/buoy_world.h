#pragma once

#include <cstdint>
#include <vector>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/fusion/beacon_localization.h"
#include "kinect_ekf_slam/models/measurement.h"
#include "kinect_ekf_slam/models/motion.h"
#include "kinect_ekf_slam/models/sensor_model.h"

namespace kinect_ekf_slam {

/// The source's robot: it dives on a closed way, sees landmarks near some parts of it and nothing on the
/// others, and hears its distance to buoys now and then. All errors are white and as the estimators assume
/// them, so what the result gets wrong is the method's own doing.
struct BuoyScenario {
  int rounds = 2;
  double speed = 0.5;               ///< m/s
  double rate = 5.0;                ///< Hz, of odometry and camera
  double linear_sigma = 0.05;       ///< m/s, of the speed in each odometry along each axis of the base
  double angular_sigma_deg = 1.0;   ///< deg/s, of each turn rate
  double beacon_period = 3.0;       ///< s between the ranges, to all buoys at one time
  double beacon_sigma = 0.4;        ///< m
  double field_of_view_deg = 57.0;  ///< horizontal, whole angle
  double vertical_field_of_view_deg = 43.0;
  SensorOptions sensor;  ///< the camera's range gate and noise model
  BuoyScenario() {
    sensor.min_depth = 0.5;
    sensor.max_depth = sensor.max_lateral = 5.0;
  }
};

/// One run of the world: the truth, and what odometry, camera and buoys say. The same seed gives the same
/// numbers when the steps are asked for in their order.
class BuoyWorld {
 public:
  BuoyWorld(const BuoyScenario& scenario, std::uint64_t seed);

  int steps() const;
  TimeNs stamp(int step) const { return to_nanoseconds(step / scenario_.rate); }
  Se3 true_pose(int step) const;
  /// m, in the world; its index is the identity that the sightings carry for the evaluation.
  const std::vector<Eigen::Vector3d>& landmarks() const { return landmarks_; }
  const BeaconLocalization<Spatial>::Beacons& beacons() const { return beacons_; }

  /// What the odometry says of the way from `step` - 1 to `step`.
  MotionStep<Spatial> drive(int step);
  std::vector<Observation<Spatial>> look(int step);
  /// Empty where none are due.
  std::vector<BeaconRange> listen(int step);

 private:
  static double way_length();
  static Eigen::Vector3d way_point(double distance);
  void place_landmarks(std::uint64_t seed);
  bool sees(const Detection& detection) const;

  BuoyScenario scenario_;
  std::vector<Eigen::Vector3d> landmarks_;
  BeaconLocalization<Spatial>::Beacons beacons_;
  RandomStream odometry_random_;
  RandomStream sensor_random_;
  RandomStream beacon_random_;
  Spatial::PoseVector odometry_sigma_;  ///< of each step
};

}  // namespace kinect_ekf_slam
