#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {

/// A normally distributed quantity. The linear Kalman filter is `predicted` and `correct` on it
/// (docs/filters.md).
template <int Dim>
struct Gaussian {
  using Vector = Eigen::Matrix<double, Dim, 1>;
  using Matrix = Eigen::Matrix<double, Dim, Dim>;
  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Zero();
};

/// x' = A x + b + n, n ~ N(0, Q).
template <int Dim>
Gaussian<Dim> predicted(const Gaussian<Dim>& x, const typename Gaussian<Dim>::Matrix& A,
                        const typename Gaussian<Dim>::Vector& b, const typename Gaussian<Dim>::Matrix& Q) {
  const typename Gaussian<Dim>::Matrix covariance = A * x.covariance * A.transpose() + Q;
  return {A * x.mean + b, covariance.template selfadjointView<Eigen::Lower>()};
}

/// How well a measurement fitted before it was used.
struct Fit {
  double squared_distance;  ///< nu^T S^-1 nu
  double log_likelihood;    ///< log N(nu; 0, S)
};

/// Nothing when `covariance` is not positive definite to working precision.
template <int Rows>
std::optional<Fit> fit_of(const Eigen::Matrix<double, Rows, 1>& innovation,
                          const Eigen::Matrix<double, Rows, Rows>& covariance) {
  const auto squared_distance = squared_mahalanobis<Rows>(innovation, covariance);
  if (!squared_distance) return std::nullopt;
  const double log_determinant = std::log(covariance.determinant());
  return Fit{*squared_distance, -0.5 * (*squared_distance + Rows * std::log(2.0 * kPi) + log_determinant)};
}

/// Takes in z = H x + v, v ~ N(0, R), given its innovation nu = z - H x. Nothing, and `x` stays, when the
/// innovation's covariance S = H P H^T + R is not positive definite to working precision.
template <int Dim, int Rows>
std::optional<Fit> correct(const Eigen::Matrix<double, Rows, 1>& innovation,
                           const Eigen::Matrix<double, Rows, Dim>& H,
                           const Eigen::Matrix<double, Rows, Rows>& R, Gaussian<Dim>* x) {
  Eigen::Matrix<double, Dim, Rows> gain = x->covariance * H.transpose();
  const Eigen::LLT<Eigen::Matrix<double, Rows, Rows>> cholesky(H * gain + R);  // S = L L^T
  if (!innovation.allFinite() || cholesky.info() != Eigen::Success || !(cholesky.rcond() > kLeastRcond)) {
    return std::nullopt;
  }
  const auto L = cholesky.matrixL();
  const Eigen::Matrix<double, Rows, 1> whitened = L.solve(innovation);
  L.transpose().template solveInPlace<Eigen::OnTheRight>(gain);  // P H^T L^-T
  const typename Gaussian<Dim>::Matrix covariance = x->covariance - gain * gain.transpose();
  x->mean += gain * whitened;
  x->covariance = covariance.template selfadjointView<Eigen::Lower>();

  const Eigen::Matrix<double, Rows, Rows> root = L;
  const double squared_distance = whitened.squaredNorm();
  return Fit{squared_distance,
             -0.5 * (squared_distance + Rows * std::log(2.0 * kPi)) - root.diagonal().array().log().sum()};
}

/// The distribution of the weighted sum a X + b Y of two independent quantities.
template <int Dim>
Gaussian<Dim> weighted_sum(double a, const Gaussian<Dim>& x, double b, const Gaussian<Dim>& y) {
  return {a * x.mean + b * y.mean, a * a * x.covariance + b * b * y.covariance};
}

/// The Gaussian with the mean and covariance of a mixture: one of `parts` is drawn, with these probabilities.
/// The covariance is that within the parts plus that between their means.
template <int Dim>
Gaussian<Dim> moments_of_mixture(const std::vector<double>& probabilities,
                                 const std::vector<Gaussian<Dim>>& parts) {
  Gaussian<Dim> moments;
  for (std::size_t i = 0; i < parts.size(); ++i) moments.mean += probabilities[i] * parts[i].mean;
  typename Gaussian<Dim>::Matrix covariance = Gaussian<Dim>::Matrix::Zero();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const typename Gaussian<Dim>::Vector offset = parts[i].mean - moments.mean;
    covariance += probabilities[i] * (parts[i].covariance + offset * offset.transpose());
  }
  moments.covariance = covariance.template selfadjointView<Eigen::Lower>();
  return moments;
}

}  // namespace kinect_ekf_slam
