#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace kinect_ekf_slam {

/// Where a sensor that knows the map says that it is: GPS, motion capture, a fiducial with a known place.
struct GlobalPosition {
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();  ///< m, of the antenna
  /// REP-103: (x, y, z, roll, pitch, yaw) in the map's axes, m^2 and rad^2. What is not measured has no part
  /// in it: the turn's rows count where there is an attitude.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::optional<Eigen::Quaterniond> map_from_base;            ///< attitude; absent: not measured
  Eigen::Vector3d antenna_in_base = Eigen::Vector3d::Zero();  ///< m: the lever arm
};

/// How far it is to a beacon: UWB, sonar.
struct BeaconRange {
  int beacon = -1;                                             ///< as the list of beacons calls it
  double range = 0.0;                                          ///< m
  double variance = 0.0;                                       ///< m^2
  Eigen::Vector3d receiver_in_base = Eigen::Vector3d::Zero();  ///< m: the lever arm
};

}  // namespace kinect_ekf_slam
