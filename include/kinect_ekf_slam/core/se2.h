#pragma once

#include <Eigen/Core>

namespace kinect_ekf_slam {

/// Rigid motion of the plane, SE(2): a pose, or the transform between two frames.
///
/// `map_from_base * point_in_base` is the point in the map. The tangent vector is (x, y, theta), and
/// perturbations are local: X * Exp(xi) with xi in the axes of the body. (Sola et al., "A micro Lie theory
/// for state estimation in robotics", arXiv 1812.01537, section IV-A.)
class Se2 {
 public:
  using Tangent = Eigen::Vector3d;
  using TangentMatrix = Eigen::Matrix3d;

  Se2() = default;
  Se2(const Eigen::Vector2d& translation, double angle);
  Se2(double x, double y, double angle) : Se2(Eigen::Vector2d(x, y), angle) {}

  /// The motion along a constant twist held for unit time: exact along the arc, smooth through zero.
  static Se2 exp(const Tangent& twist);
  /// The twist that takes unit time to reach this motion, angle in (-pi, pi].
  Tangent log() const;

  const Eigen::Vector2d& translation() const { return translation_; }
  /// rad, in (-pi, pi].
  double angle() const { return angle_; }
  const Eigen::Matrix2d& rotation() const { return rotation_; }

  Se2 inverse() const;
  Se2 operator*(const Se2& other) const;
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const { return translation_ + rotation_ * point; }

  /// Ad with X Exp(xi) = Exp(Ad xi) X.
  TangentMatrix adjoint() const;

 private:
  Eigen::Vector2d translation_ = Eigen::Vector2d::Zero();
  double angle_ = 0.0;
  Eigen::Matrix2d rotation_ = Eigen::Matrix2d::Identity();
};

/// J v is v turned by +90 degrees: d(R(a) v)/da = R(a) J v.
inline Eigen::Matrix2d quarter_turn() { return (Eigen::Matrix2d() << 0.0, -1.0, 1.0, 0.0).finished(); }

}  // namespace kinect_ekf_slam
