#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/se2.h"
#include "kinect_ekf_slam/core/se3.h"

namespace kinect_ekf_slam::testing {

/// Every entry within `tolerance`; prints both matrices when not.
template <class Left, class Right>
::testing::AssertionResult MatrixNear(const Eigen::MatrixBase<Left>& left,
                                      const Eigen::MatrixBase<Right>& right, double tolerance) {
  if (left.rows() == right.rows() && left.cols() == right.cols()) {
    const double difference = left.size() == 0 ? 0.0 : (left - right).cwiseAbs().maxCoeff();
    if (difference <= tolerance) return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "\n" << left << "\nis not within " << tolerance << " of\n" << right;
}

/// The angle between two headings, whichever is the larger, at most `tolerance`.
inline ::testing::AssertionResult AngleNear(double left, double right, double tolerance) {
  if (std::abs(wrap_angle(left - right)) <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << left << " and " << right << " differ by more than " << tolerance;
}

inline ::testing::AssertionResult PoseNear(const Se2& left, const Se2& right, double tolerance) {
  const auto position = MatrixNear(left.translation(), right.translation(), tolerance);
  return position ? AngleNear(left.angle(), right.angle(), tolerance) : position;
}

inline ::testing::AssertionResult PoseNear(const Se3& left, const Se3& right, double tolerance) {
  const auto position = MatrixNear(left.translation(), right.translation(), tolerance);
  return position ? MatrixNear(left.rotation(), right.rotation(), tolerance) : position;
}

/// Symmetric to the last bit, and no eigenvalue below -`tolerance` times the largest.
inline ::testing::AssertionResult IsCovariance(const Eigen::MatrixXd& matrix, double tolerance = 1e-12) {
  if (matrix != matrix.transpose()) return ::testing::AssertionFailure() << "not symmetric:\n" << matrix;
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues();
  if (eigenvalues.minCoeff() >= -tolerance * eigenvalues.maxCoeff()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "smallest eigenvalue " << eigenvalues.minCoeff();
}

/// Central differences of `function` (vector to vector) at `x`, for the columns of a Jacobian.
template <class Function>
Eigen::MatrixXd numerical_jacobian(const Function& function, const Eigen::VectorXd& x, double step = 1e-6) {
  const Eigen::VectorXd at_x = function(x);
  Eigen::MatrixXd jacobian(at_x.size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd up = x;
    Eigen::VectorXd down = x;
    up(i) += step;
    down(i) -= step;
    jacobian.col(i) = (function(up) - function(down)) / (2.0 * step);
  }
  return jacobian;
}

}  // namespace kinect_ekf_slam::testing
