#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "kinect_ekf_slam/core/se2.h"
#include "kinect_ekf_slam/core/se3.h"

namespace kinect_ekf_slam {

/// Velocity of the robot's base in its own axes; what odometry and a gyro measure, in whatever space.
struct BodyVelocity {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< rad/s
  std::array<bool, 3> turned_by_gyro{};               ///< per axis: the rate is a gyro's, not the wheels'
};

/// A space is all that an algorithm must know about the world's geometry: poses, points, and how they embed
/// in the three dimensions in which sensors and ROS speak. Algorithms are written once, over the space.
///
/// What every space has by its dimensions. A pose's tangent is (translation, turn).
template <class PoseType, int kPoseDimension, int kPointDimension>
struct SpaceTypes {
  static constexpr int kPoseDim = kPoseDimension;
  static constexpr int kPointDim = kPointDimension;
  static constexpr int kTurnDim = kPoseDim - kPointDim;

  using Pose = PoseType;
  using Point = Eigen::Matrix<double, kPointDim, 1>;
  using PointMatrix = Eigen::Matrix<double, kPointDim, kPointDim>;
  using PoseVector = Eigen::Matrix<double, kPoseDim, 1>;
  using PoseMatrix = Eigen::Matrix<double, kPoseDim, kPoseDim>;
  using PointByTurn = Eigen::Matrix<double, kPointDim, kTurnDim>;
  using PointByPose = Eigen::Matrix<double, kPointDim, kPoseDim>;
};

/// Planar: pose (x, y, theta) in SE(2), landmarks (x, y): a state of 3 + 2n.
struct Planar : SpaceTypes<Se2, 3, 2> {
  static constexpr const char* kName = "planar";
  /// Where the space's pose error (x, y, theta) stands in REP-103's (x, y, z, roll, pitch, yaw).
  static constexpr int kPoseAxes[kPoseDim] = {0, 1, 5};
  static constexpr int kPoseNumbers = 3;  ///< of to_vector: x, y, heading

  /// Twist of the pose's tangent space from the base's velocity.
  static PoseVector twist(const BodyVelocity& velocity) {
    return {velocity.linear.x(), velocity.linear.y(), velocity.angular.z()};
  }
  /// d(Exp(turn) point)/d turn at zero.
  static PointByTurn by_turn(const Point& point) { return quarter_turn() * point; }
  /// d(Exp(-xi) point)/d xi at zero: how a point in the base moves when the base is perturbed.
  static PointByPose point_by_pose(const Point& point_in_base) {
    return (PointByPose() << -PointMatrix::Identity(), -by_turn(point_in_base)).finished();
  }
  /// The pose after a local perturbation. The translation moves along a straight line, as the linear errors
  /// of a Kalman filter do; to first order this is pose * Exp(xi).
  static Pose retract(const Pose& pose, const PoseVector& local) {
    return {Point(pose * Point(local.head<kPointDim>())), pose.angle() + local(2)};
  }
  static Eigen::VectorXd to_vector(const Pose& pose) {
    return PoseVector(pose.translation().x(), pose.translation().y(), pose.angle());
  }
  static Pose pose_from_vector(const Eigen::VectorXd& vector) { return {vector(0), vector(1), vector(2)}; }
  static Point from_3d(const Eigen::Vector3d& point) { return point.head<2>(); }
  static PointMatrix from_3d(const Eigen::Matrix3d& covariance) { return covariance.topLeftCorner<2, 2>(); }
  static Eigen::Vector3d to_3d(const Point& point) { return {point.x(), point.y(), 0.0}; }
  static Eigen::Isometry3d to_3d(const Pose& pose) {
    Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
    transform.translation() = to_3d(pose.translation());
    transform.linear() = Eigen::AngleAxisd(pose.angle(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return transform;
  }
  static Pose pose_from_3d(const Eigen::Isometry3d& pose) {
    const Eigen::Vector3d forward = pose.linear().col(0);
    return {Point(pose.translation().head<2>()), std::atan2(forward.y(), forward.x())};
  }
};

/// Spatial: pose in SE(3), landmarks (x, y, z): a state whose error has 6 + 3n numbers.
struct Spatial : SpaceTypes<Se3, 6, 3> {
  static constexpr const char* kName = "spatial";
  static constexpr int kPoseAxes[kPoseDim] = {0, 1, 2, 3, 4, 5};
  static constexpr int kPoseNumbers = 7;  ///< of to_vector: x, y, z, then the quaternion x, y, z, w

  static PoseVector twist(const BodyVelocity& velocity) {
    return (PoseVector() << velocity.linear, velocity.angular).finished();
  }
  static PointByTurn by_turn(const Point& point) { return -hat(point); }
  static PointByPose point_by_pose(const Point& point_in_base) {
    return (PointByPose() << -PointMatrix::Identity(), -by_turn(point_in_base)).finished();
  }
  static Pose retract(const Pose& pose, const PoseVector& local) {
    return {Point(pose * Point(local.head<3>())), pose.attitude() * rotation_exp(local.tail<3>())};
  }
  static Eigen::VectorXd to_vector(const Pose& pose) {
    Eigen::VectorXd vector(kPoseNumbers);
    vector << pose.translation(), pose.attitude().coeffs();
    return vector;
  }
  static Pose pose_from_vector(const Eigen::VectorXd& vector) {
    return {Point(vector.head<3>()), Eigen::Quaterniond(Eigen::Vector4d(vector.tail<4>()))};
  }
  static Point from_3d(const Eigen::Vector3d& point) { return point; }
  static PointMatrix from_3d(const Eigen::Matrix3d& covariance) { return covariance; }
  static Eigen::Vector3d to_3d(const Point& point) { return point; }
  static Eigen::Isometry3d to_3d(const Pose& pose) {
    Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
    transform.translation() = pose.translation();
    transform.linear() = pose.rotation();
    return transform;
  }
  static Pose pose_from_3d(const Eigen::Isometry3d& pose) {
    return {Point(pose.translation()), Eigen::Quaterniond(pose.linear())};
  }
};

}  // namespace kinect_ekf_slam
