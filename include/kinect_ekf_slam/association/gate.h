#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <optional>

namespace kinect_ekf_slam {

/// Reciprocal condition below which S is taken for singular: a pose known to 10 km and a sensor good to a
/// millimetre are still far from it.
constexpr double kLeastRcond = 1e-15;

/// nu^T S^-1 nu, or nothing when S is not regular: not positive definite to working precision.
template <int Dim>
std::optional<double> squared_mahalanobis(const Eigen::Matrix<double, Dim, 1>& innovation,
                                          const Eigen::Matrix<double, Dim, Dim>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, Dim, Dim>> cholesky(covariance);
  if (!innovation.allFinite() || cholesky.info() != Eigen::Success || !(cholesky.rcond() > kLeastRcond)) {
    return std::nullopt;
  }
  return cholesky.matrixL().solve(innovation).squaredNorm();
}

}  // namespace kinect_ekf_slam
