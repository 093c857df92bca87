#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <unsupported/Eigen/Splines>
#include <vector>

#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// A path as a clamped cubic B-spline over time, through all of its points, equation (13.1).
///
/// u = (t - t_0) / (t_n - t_0). The control points are fitted: a spline that takes the points themselves for
/// control points does not pass through them. What the spline tells is linear in the points, S(t) = sum
/// w_i(t) p_i, and so are its errors. Fewer than four points give a spline of a lower degree; a single one
/// stands still.
template <int Dim>
class PathSpline {
 public:
  using Point = Eigen::Matrix<double, Dim, 1>;
  using Matrix = Eigen::Matrix<double, Dim, Dim>;

  /// Throws std::invalid_argument unless there are as many points (m) as stamps, at least one, and the stamps
  /// ascend.
  PathSpline(std::vector<TimeNs> stamps, const std::vector<Point>& points);

  TimeNs start() const { return stamps_.front(); }
  TimeNs end() const { return stamps_.back(); }
  bool covers(TimeNs stamp) const { return start() <= stamp && stamp <= end(); }

  /// S(t), m. `stamp` is covered.
  Point position(TimeNs stamp) const;

  /// Row k: the weights w_i(t_k) of the points, equation (13.2). They sum to one; at a point's own time it
  /// has all of it.
  Eigen::MatrixXd weights(const std::vector<TimeNs>& stamps) const;

  /// P(t) = sum w_i(t)^2 P_i, equation (13.3), m^2: if the points' errors are independent. One entry of
  /// `covariances` a point.
  Matrix covariance(TimeNs stamp, const std::vector<Matrix>& covariances) const;

 private:
  double parameter(TimeNs stamp) const;
  Eigen::SparseVector<double> basis(TimeNs stamp) const;

  std::vector<TimeNs> stamps_;
  int degree_;
  Eigen::Array<double, 1, Eigen::Dynamic> knots_;
  Eigen::SparseMatrix<double> collocation_;  ///< row k: N_i at the time of point k
  Eigen::Matrix<double, Dim, Eigen::Dynamic> control_points_;
};

}  // namespace kinect_ekf_slam
