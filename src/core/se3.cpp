#include "kinect_ekf_slam/core/se3.h"

#include <Eigen/LU>
#include <cmath>

namespace kinect_ekf_slam {
namespace {

/// V of Exp(rho, phi) = (V rho, Exp(phi)): the mean of the rotations on the way, with its Taylor series where
/// the quotients would lose digits. (Sola et al., equation 174.)
Eigen::Matrix3d screw_matrix(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  constexpr double kSmall = 1e-4;  // the first neglected terms are below 1e-17
  const double square = angle * angle;
  const double first = angle < kSmall ? 0.5 - square / 24.0 : (1.0 - std::cos(angle)) / square;
  const double second =
      angle < kSmall ? 1.0 / 6.0 - square / 120.0 : (angle - std::sin(angle)) / (square * angle);
  const Eigen::Matrix3d cross = hat(rotation);
  return Eigen::Matrix3d::Identity() + first * cross + second * cross * cross;
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0).finished();
}

Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& vector) {
  const double half = 0.5 * vector.norm();
  constexpr double kSmall = 1e-4;
  const double sine_ratio = half < kSmall ? 0.5 - half * half / 12.0 : 0.5 * std::sin(half) / half;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(half);
  rotation.vec() = sine_ratio * vector;
  return rotation;
}

Eigen::Vector3d rotation_log(const Eigen::Quaterniond& rotation) {
  const double sine = rotation.vec().norm();
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;  // q and -q are one rotation: the shorter way
  constexpr double kSmall = 1e-7;
  const double ratio =
      sine < kSmall ? 2.0 / rotation.w() : 2.0 * sign * std::atan2(sine, sign * rotation.w()) / sine;
  return ratio * rotation.vec();
}

Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Se3::Se3(const Eigen::Vector3d& translation, const Eigen::Quaterniond& attitude)
    : translation_(translation), attitude_(attitude.normalized()), rotation_(attitude_.toRotationMatrix()) {}

Se3 Se3::exp(const Tangent& twist) {
  return {screw_matrix(twist.tail<3>()) * twist.head<3>(), rotation_exp(twist.tail<3>())};
}

Se3::Tangent Se3::log() const {
  Tangent twist;
  twist.tail<3>() = rotation_log(attitude_);
  twist.head<3>() = screw_matrix(twist.tail<3>()).partialPivLu().solve(translation_);
  return twist;
}

Se3 Se3::inverse() const { return {-(rotation_.transpose() * translation_), attitude_.conjugate()}; }

Se3 Se3::operator*(const Se3& other) const {
  return {*this * other.translation_, attitude_ * other.attitude_};
}

Se3::TangentMatrix Se3::adjoint() const {
  TangentMatrix adjoint = TangentMatrix::Zero();
  adjoint.topLeftCorner<3, 3>() = adjoint.bottomRightCorner<3, 3>() = rotation_;
  adjoint.topRightCorner<3, 3>() = hat(translation_) * rotation_;
  return adjoint;
}

}  // namespace kinect_ekf_slam
