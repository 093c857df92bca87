#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kinect_ekf_slam {

/// [v]x: hat(v) w is the cross product v x w.
Eigen::Matrix3d hat(const Eigen::Vector3d& vector);

/// The rotation by |vector| rad about the vector.
Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& vector);

/// The shortest vector whose rotation this is, its length in [0, pi].
Eigen::Vector3d rotation_log(const Eigen::Quaterniond& rotation);

/// The rotation by roll, pitch and yaw (rad) about fixed axes: x first, then y, then z, as URDF and tf say
/// it.
Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& roll_pitch_yaw);

/// Rigid motion of space, SE(3): a pose, or the transform between two frames. The spatial sibling of Se2.
///
/// The attitude is kept as a unit quaternion, so no attitude is special. The tangent vector is (translation,
/// rotation), and perturbations are local: X * Exp(xi) with xi in the axes of the body. (Sola et al.,
/// arXiv 1812.01537, section IV-B.)
class Se3 {
 public:
  using Tangent = Eigen::Matrix<double, 6, 1>;
  using TangentMatrix = Eigen::Matrix<double, 6, 6>;

  Se3() = default;
  Se3(const Eigen::Vector3d& translation, const Eigen::Quaterniond& attitude);

  /// The motion along a constant twist held for unit time: exact along the screw, smooth through zero.
  static Se3 exp(const Tangent& twist);
  /// The twist that takes unit time to reach this motion, its rotation no longer than pi.
  Tangent log() const;

  const Eigen::Vector3d& translation() const { return translation_; }
  const Eigen::Quaterniond& attitude() const { return attitude_; }
  const Eigen::Matrix3d& rotation() const { return rotation_; }

  Se3 inverse() const;
  Se3 operator*(const Se3& other) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return translation_ + rotation_ * point; }

  /// Ad with X Exp(xi) = Exp(Ad xi) X.
  TangentMatrix adjoint() const;

 private:
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond attitude_ = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
};

}  // namespace kinect_ekf_slam
