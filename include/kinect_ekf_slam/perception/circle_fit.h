#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace kinect_ekf_slam {

/// A point of an outline, measured along the ray from the sensor at the origin.
struct OutlinePoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m
  double sigma = 0.0;                                  ///< m, along the ray
  double sigma_aside = 0.0;                            ///< m, across it
};

using Outline = std::vector<OutlinePoint>;

/// The circle of a round object's outline, as seen by a sensor at the origin.
struct Circle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();      ///< m
  double radius = 0.0;                                   ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2, of centre x, centre y and radius
  double chi_square = 0.0;                               ///< of the points' residuals

  /// Distance of a point outside the circle, in units of its standard deviation there.
  double residual(const OutlinePoint& point) const;
  /// Where a point lies around the axis, rad in (-pi, pi], 0: towards the sensor, positive: to its
  /// left.
  double bearing(const Eigen::Vector2d& point) const;
};

/// How far round a circle its outline reaches, to the right and to the left of the direction to the sensor.
struct Arc {
  double right = 0.0;  ///< rad
  double left = 0.0;

  double whole() const { return left + right; }
  /// 1: as much on one side as on the other, 0: one side only.
  double symmetry() const;
  /// It is not the outside that is seen: a bowl, a cup, a corner of walls.
  bool is_hollow() const;
};

/// The arc of an outline that is not empty.
Arc arc_of(const Circle& circle, const Outline& outline);

/// Bounds of the radius, and what they say of it beforehand: two standard deviations on each side of the
/// mean.
struct RadiusBounds {
  double min = 0.0;  ///< m
  double max = 0.0;  ///< m

  double mean() const { return 0.5 * (min + max); }
  double sigma() const { return 0.25 * (max - min); }
  bool contain(double radius) const { return radius >= min && radius <= max; }
};

/// The circle with the least squared weighted residuals; none when the iteration does not converge or there
/// are fewer than three points.
///
/// Starts at the algebraic fit (Kasa, IEEE Trans. Instrum. Meas. 25(1), 1976) and refines by Gauss-Newton.
/// Residuals are radial, so that a point's residual varies with the ray's incidence. What is known of the
/// radius enters as one more residual: a short arc determines its radius, and with it the distance of the
/// axis, badly.
std::optional<Circle> fit_circle(const Outline& outline, const RadiusBounds& bounds);

/// Chi-square of the outline, in the order of its points, as two straight pieces: the corner of a box, or one
/// flat face. What such a corner explains better than a circle is no cylinder. Fewer than six points:
/// infinity.
double corner_chi_square(const Outline& outline);

}  // namespace kinect_ekf_slam
