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

/// What became of a position or a range.
enum class PositionVerdict {
  kUsed,
  kAligning,       ///< taken to find out where the map lies in the frame of the positions
  kOutsideGate,    ///< contradicts the estimate
  kSingular,       ///< tells nothing here: a range of zero, or S not positive definite
  kInvalid,        ///< not finite, or no covariance
  kLate,           ///< older than what the estimate already holds
  kWithheld,       ///< compared, not used: for evaluations
  kUnknownBeacon,  ///< a range to a beacon that is not in the list
  kUnsupported,    ///< the estimator is no Kalman filter
};
constexpr int kPositionVerdictCount = static_cast<int>(PositionVerdict::kUnsupported) + 1;

/// The verdict's name in files and diagnostics: lower case, words joined by `_`.
const char* to_string(PositionVerdict verdict);

/// A beacon stands in the map among the landmarks, but nobody sees it: its id there, out of the landmarks'
/// way.
constexpr int beacon_landmark_id(int beacon) { return -2 - beacon; }
constexpr int beacon_of(int landmark_id) { return -2 - landmark_id; }
constexpr bool is_beacon(int landmark_id) { return landmark_id <= -2; }

}  // namespace kinect_ekf_slam
