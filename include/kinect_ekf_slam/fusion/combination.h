#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <limits>
#include <optional>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/estimators/gaussian.h"

namespace kinect_ekf_slam {

/// What became of two independent estimates of one thing. Those that disagree are not averaged: both are
/// told.
template <int Dim>
struct Combination {
  Gaussian<Dim> first;
  Gaussian<Dim> second;
  /// (b - c)^T (P_b + P_c)^-1 (b - c): chi-square with Dim degrees of freedom when both are right.
  double squared_distance = std::numeric_limits<double>::infinity();
  std::optional<Gaussian<Dim>> fused;  ///< nothing: they do not overlap
};

/// Covariance-weighted fusion of independent estimates, equations (13.7) and (13.8): P = (P_b^-1 +
/// P_c^-1)^-1, x = P (P_b^-1 b + P_c^-1 c), computed in the Kalman form, which needs no inverse. They overlap
/// when their squared distance lies below the chi-square quantile of `gate_probability`; never, when P_b +
/// P_c is singular.
template <int Dim>
Combination<Dim> combine(const Gaussian<Dim>& first, const Gaussian<Dim>& second, double gate_probability) {
  Combination<Dim> result;
  result.first = first;
  result.second = second;
  Gaussian<Dim> fused = first;
  const typename Gaussian<Dim>::Vector innovation = second.mean - first.mean;
  const auto fit =
      correct<Dim, Dim>(innovation, Gaussian<Dim>::Matrix::Identity(), second.covariance, &fused);
  if (!fit) return result;
  result.squared_distance = fit->squared_distance;
  if (fit->squared_distance < chi_square_quantile(gate_probability, Dim)) result.fused = fused;
  return result;
}

/// Covariance intersection, equation (13.9), of estimates whose correlation nobody knows: P^-1 = w P_b^-1 +
/// (1 - w) P_c^-1 with the w in [0, 1] of the least determinant. Its covariance is never too small, whatever
/// the correlation. (Julier and Uhlmann, American Control Conference 1997.) Both covariances are positive
/// definite.
template <int Dim>
Gaussian<Dim> covariance_intersection(const Gaussian<Dim>& first, const Gaussian<Dim>& second) {
  using Matrix = typename Gaussian<Dim>::Matrix;
  const Eigen::LLT<Matrix> first_root(first.covariance);
  const Eigen::LLT<Matrix> second_root(second.covariance);
  const Matrix first_information = first_root.solve(Matrix::Identity());
  const Matrix second_information = second_root.solve(Matrix::Identity());
  // Where P_b is the identity P_c^-1 has these eigenvalues m, and ln det P^-1 is sum ln(w + (1 - w) m) but
  // for a constant. That is concave in w: its slope falls through zero at the best w.
  const Matrix L = first_root.matrixL();
  const Eigen::Matrix<double, Dim, 1> m =
      Eigen::SelfAdjointEigenSolver<Matrix>(L.transpose() * second_information * L).eigenvalues();
  double low = 0.0;
  double high = 1.0;
  for (int halving = 0; halving < 60; ++halving) {
    const double w = 0.5 * (low + high);
    const double slope = ((1.0 - m.array()) / (w + (1.0 - w) * m.array())).sum();
    (slope > 0.0 ? low : high) = w;
  }
  const double w = 0.5 * (low + high);
  const Eigen::LLT<Matrix> information(w * first_information + (1.0 - w) * second_information);
  Gaussian<Dim> result;
  result.mean =
      information.solve(w * first_information * first.mean + (1.0 - w) * second_information * second.mean);
  result.covariance = information.solve(Matrix::Identity());
  result.covariance = Matrix(result.covariance.template selfadjointView<Eigen::Lower>());
  return result;
}

}  // namespace kinect_ekf_slam
