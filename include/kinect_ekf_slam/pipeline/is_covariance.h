#pragma once

#include <Eigen/Cholesky>

namespace kinect_ekf_slam {

/// Finite, symmetric, positive definite, and with variances that say something: in all less than 1e6 (m^2),
/// whose digits would drown those of the map.
template <class Matrix>
bool is_covariance(const Matrix& matrix) {
  constexpr double kLargest = 1e6;
  return matrix.allFinite() && matrix.trace() < kLargest && matrix.isApprox(matrix.transpose(), 1e-6) &&
         Eigen::LLT<Matrix>(matrix).info() == Eigen::Success;
}

}  // namespace kinect_ekf_slam
