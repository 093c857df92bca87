#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"

namespace kinect_ekf_slam {

/// The pieces of every particle filter (docs/filters.md): weights, resampling, drawing, and the mean pose.

/// Weights of sum one from the logarithms of weights of any sum: w_i = exp(l_i) / sum_j exp(l_j), without
/// overflow. Equal weights when none is finite. At least one.
std::vector<double> normalized_weights(const std::vector<double>& log_weights);

/// 1 / sum w_i^2: how many equally weighted particles would tell as much.
double effective_sample_size(const std::vector<double>& weights);

/// Low-variance resampling: `count` indices in ascending order, index i about `count * weights[i]` times, to
/// less than one. One random number in [0, 1) decides all. (Thrun, Burgard, Fox: Probabilistic Robotics,
/// table 4.4.)
std::vector<std::size_t> low_variance_resample(const std::vector<double>& weights, std::size_t count,
                                               double random);

/// A root A of a covariance, A A^T = P to working precision; P may be singular, zero as well.
template <class Matrix>
Matrix covariance_root(const Matrix& covariance) {
  constexpr double kJitter = 1e-12;  // of the mean variance: keeps the factor of a singular matrix real
  const double jitter = kJitter * covariance.trace() / static_cast<double>(covariance.rows());
  if (!(jitter > 0.0)) return Matrix::Zero(covariance.rows(), covariance.cols());
  const Matrix regular = covariance + jitter * Matrix::Identity(covariance.rows(), covariance.cols());
  return regular.llt().matrixL();
}

/// `count` columns of standard normal numbers whose mean is exactly zero and, with more columns than rows,
/// whose covariance is exactly one: what is drawn with them has the mean and covariance that it should have.
Eigen::MatrixXd standardized_draws(int dimension, int count, RandomStream* random);

/// One step and then another as one step.
template <class Space>
MotionStep<Space> compound(const MotionStep<Space>& first, const MotionStep<Space>& second) {
  const typename Space::PoseMatrix A =
      second.delta.inverse().adjoint();  // brings the error to the second's end
  const typename Space::PoseMatrix covariance = A * first.covariance * A.transpose() + second.covariance;
  return {first.delta * second.delta, covariance.template selfadjointView<Eigen::Lower>()};
}

/// The inverse of Space::retract: the local perturbation that moves `from` to `to`.
template <class Space>
typename Space::PoseVector local_difference(const typename Space::Pose& from,
                                            const typename Space::Pose& to) {
  typename Space::PoseVector local = (from.inverse() * to).log();
  local.template head<Space::kPointDim>() =
      from.rotation().transpose() * (to.translation() - from.translation());
  return local;
}

/// Mean and covariance of weighted poses: the pose from which the weighted perturbations add up to zero.
template <class Space>
PoseEstimate<Space> mean_of_poses(const std::vector<typename Space::Pose>& poses,
                                  const std::vector<double>& weights) {
  constexpr int kMostRounds = 10;  // two are usual
  constexpr double kSettled = 1e-12;
  PoseEstimate<Space> estimate;
  typename Space::Pose& mean = estimate.map_from_base;
  mean = poses[static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin())];
  for (int round = 0; round < kMostRounds; ++round) {
    typename Space::PoseVector shift = Space::PoseVector::Zero();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      shift += weights[i] * local_difference<Space>(mean, poses[i]);
    }
    mean = Space::retract(mean, shift);
    if (shift.norm() < kSettled) break;
  }
  typename Space::PoseMatrix covariance = Space::PoseMatrix::Zero();
  const typename Space::PoseMatrix T = error_from_local<Space>(mean);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const typename Space::PoseVector error = T * local_difference<Space>(mean, poses[i]);
    covariance += weights[i] * error * error.transpose();
  }
  estimate.covariance = covariance.template selfadjointView<Eigen::Lower>();
  return estimate;
}

}  // namespace kinect_ekf_slam
