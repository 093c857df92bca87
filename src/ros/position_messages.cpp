#include "kinect_ekf_slam/ros/position_messages.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/ros/conversions.h"

namespace kinect_ekf_slam {
namespace {

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kAnyAngle = kPi * kPi / 3.0;  // rad^2, of an angle of which nothing is known
constexpr double kAnyHeight = 1e4;             // m^2
constexpr int kHeight = 2;                     // of REP-103's x, y, z, roll, pitch, yaw
constexpr int kFirstAngle = 3;
constexpr int kYaw = 5;

/// What a source in the plane leaves at zero is not known: unknown is never zero.
Eigen::Matrix<double, 6, 6> completed(const geometry_msgs::PoseWithCovariance& message) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Map<const RowMajor6d>(message.covariance.data());
  for (int axis = kHeight; axis < 6; ++axis) {
    if (covariance(axis, axis) == 0.0) covariance(axis, axis) = axis < kFirstAngle ? kAnyHeight : kAnyAngle;
  }
  return covariance;
}

bool is_covariance(const Eigen::MatrixXd& matrix) {
  return matrix.allFinite() && matrix.isApprox(matrix.transpose(), 1e-6) &&
         Eigen::LLT<Eigen::MatrixXd>(matrix).info() == Eigen::Success;
}

bool tells_attitude(const Eigen::Matrix<double, 6, 6>& covariance) {
  return covariance(kYaw, kYaw) > 0.0 && covariance(kYaw, kYaw) < kAnyAngle;
}

std::string number(double value) { return std::to_string(value); }

}  // namespace

GlobalPosition to_position(const geometry_msgs::PoseWithCovariance& message,
                           const Eigen::Isometry3d& base_from_antenna) {
  GlobalPosition position;
  position.position_in_map = to_eigen(message.pose.position);
  position.antenna_in_base = base_from_antenna.translation();
  position.covariance = completed(message);
  if (tells_attitude(position.covariance)) {
    position.map_from_base =
        Eigen::Quaterniond(to_eigen(message.pose).linear() * base_from_antenna.linear().transpose());
  }
  return position;
}

std::optional<MessageProblem> problem_of(const geometry_msgs::PoseWithCovariance& message) {
  if (!to_eigen(message.pose.position).allFinite())
    return MessageProblem{"not finite", "its position is not finite"};
  const Eigen::Map<const RowMajor6d> given(message.covariance.data());
  if (given.isZero(0.0)) {
    return MessageProblem{"no covariance",
                          "its covariance is all zero: how sure the position is must be told"};
  }
  const Eigen::Matrix<double, 6, 6> covariance = completed(message);
  if (!is_covariance(covariance.topLeftCorner<3, 3>())) {
    return MessageProblem{"no covariance",
                          "its covariance is no covariance of a position: not finite, not "
                          "symmetric or not positive"};
  }
  if (tells_attitude(covariance) && (!is_covariance(covariance) || !is_pose(message.pose))) {
    return MessageProblem{"no covariance",
                          "its covariance tells an attitude that is none, or is not positive"};
  }
  return std::nullopt;
}

GlobalPosition to_position(const sensor_msgs::NavSatFix& message, const LocalTangentPlane& plane,
                           const Eigen::Isometry3d& base_from_antenna, double sigma) {
  GlobalPosition position;
  position.position_in_map = plane({message.latitude, message.longitude, message.altitude});
  position.antenna_in_base = base_from_antenna.translation();
  const bool has_covariance =
      message.position_covariance_type != sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
  position.covariance.topLeftCorner<3, 3>() =
      has_covariance ? Eigen::Matrix3d(Eigen::Map<const RowMajor3d>(message.position_covariance.data()))
                     : Eigen::Matrix3d(sigma * sigma * Eigen::Matrix3d::Identity());
  return position;
}

std::optional<MessageProblem> problem_of(const sensor_msgs::NavSatFix& message, double sigma) {
  if (message.status.status < sensor_msgs::NavSatStatus::STATUS_FIX) {
    return MessageProblem{
        "no fix", "its status is " + std::to_string(message.status.status) + ": the receiver has no fix"};
  }
  if (!std::isfinite(message.altitude) || !(std::abs(message.latitude) <= 90.0) ||
      !(std::abs(message.longitude) <= 360.0)) {
    return MessageProblem{"not finite", "latitude " + number(message.latitude) + ", longitude " +
                                            number(message.longitude) + ", altitude " +
                                            number(message.altitude) + " is no place on the Earth"};
  }
  const bool has_covariance =
      message.position_covariance_type != sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
  if (!has_covariance && !(sigma > 0.0)) {
    return MessageProblem{"no covariance",
                          "its covariance is unknown; set fusion/fix_sigma to use such fixes"};
  }
  if (has_covariance && !is_covariance(Eigen::Map<const RowMajor3d>(message.position_covariance.data()))) {
    return MessageProblem{"no covariance", "its covariance is not finite, not symmetric or not positive"};
  }
  return std::nullopt;
}

std::optional<MessageProblem> problem_of_distance(const Eigen::Vector3d& position) {
  constexpr double kFarthest =
      1e5;  // m; there the plane is 800 m above the ground, and 1 in 10,000 too short
  if (position.norm() <= kFarthest) return std::nullopt;
  return MessageProblem{"far from the datum", "it is " + std::to_string(std::lround(1e-3 * position.norm())) +
                                                  " km from the datum, allowed: 100 km; see fusion/datum"};
}

Pose3d to_initial_pose(const geometry_msgs::PoseWithCovariance& message) {
  Pose3d pose;
  pose.map_from_base = to_eigen(message.pose);
  const Eigen::Map<const RowMajor6d> given(message.covariance.data());
  pose.covariance = 0.5 * (given + given.transpose());
  Eigen::Matrix<double, 6, 1> usual;  // m^2 and rad^2, what RViz gives for x, y and yaw alone
  usual << 0.25, 0.25, 0.25, 0.07, 0.07, 0.07;
  for (int axis = 0; axis < 6; ++axis) {
    if (!(pose.covariance(axis, axis) > 0.0)) pose.covariance(axis, axis) = usual(axis);
  }
  return pose;
}

std::optional<MessageProblem> problem_of_initial_pose(const geometry_msgs::PoseWithCovariance& message) {
  if (!is_pose(message.pose))
    return MessageProblem{"not finite", "its pose is not finite, or its quaternion is none"};
  constexpr double kMost = 1e6;  // m^2 and rad^2
  const Eigen::Map<const RowMajor6d> given(message.covariance.data());
  const bool says_where = given(0, 0) > 0.0 && given(1, 1) > 0.0 && given(kYaw, kYaw) > 0.0;
  const bool is_fine =
      given.isZero(0.0) ||
      (given.allFinite() && says_where && given.maxCoeff() <= kMost &&
       Eigen::SelfAdjointEigenSolver<RowMajor6d>(0.5 * (given + given.transpose())).eigenvalues()(0) > -1e-9);
  if (!is_fine) {
    return MessageProblem{"no covariance",
                          "its covariance is no covariance: not finite, not positive, or beyond 1e6"};
  }
  return std::nullopt;
}

std::vector<BeaconRange> to_ranges(const BeaconRanges& message, const Eigen::Isometry3d& base_from_receiver) {
  std::vector<BeaconRange> ranges;
  for (const auto& measured : message.ranges) {
    ranges.push_back({measured.beacon, measured.range, measured.variance, base_from_receiver.translation()});
  }
  return ranges;
}

}  // namespace kinect_ekf_slam
