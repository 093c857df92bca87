#include "kinect_ekf_slam/core/se2.h"

#include <Eigen/LU>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

/// sin(a)/a and (1 - cos(a))/a, with their Taylor series where the quotient would lose digits.
struct ArcFactors {
  double sine;
  double versine;
};

ArcFactors arc_factors(double angle) {
  constexpr double kSmall = 1e-4;  // the first neglected terms are below 1e-17
  if (std::abs(angle) < kSmall) {
    const double square = angle * angle;
    return {1.0 - square / 6.0, angle * (0.5 - square / 24.0)};
  }
  return {std::sin(angle) / angle, (1.0 - std::cos(angle)) / angle};
}

Eigen::Matrix2d arc_matrix(double angle) {
  const auto [sine, versine] = arc_factors(angle);
  return (Eigen::Matrix2d() << sine, -versine, versine, sine).finished();
}

}  // namespace

Se2::Se2(const Eigen::Vector2d& translation, double angle)
    : translation_(translation), angle_(wrap_angle(angle)) {
  const double sine = std::sin(angle_);
  const double cosine = std::cos(angle_);
  rotation_ << cosine, -sine, sine, cosine;
}

Se2 Se2::exp(const Tangent& twist) { return {arc_matrix(twist.z()) * twist.head<2>(), twist.z()}; }

Se2::Tangent Se2::log() const {
  const Eigen::Matrix2d arc = arc_matrix(angle_);  // a rotation times a length: its inverse is its transpose
  Tangent twist;
  twist << arc.transpose() * translation_ / arc.determinant(), angle_;
  return twist;
}

Se2 Se2::inverse() const { return {-(rotation_.transpose() * translation_), -angle_}; }

Se2 Se2::operator*(const Se2& other) const { return {*this * other.translation_, angle_ + other.angle_}; }

Se2::TangentMatrix Se2::adjoint() const {
  TangentMatrix adjoint = TangentMatrix::Identity();
  adjoint.topLeftCorner<2, 2>() = rotation_;
  adjoint.topRightCorner<2, 1>() = -quarter_turn() * translation_;
  return adjoint;
}

}  // namespace kinect_ekf_slam
