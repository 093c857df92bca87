#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinect_ekf_slam/core/stamped.h"
#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/estimators/gaussian.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"

namespace kinect_ekf_slam {

/// Lagrange's weights xi_i of samples taken at `samples`, for the time `stamp`, equation (13.4). They sum to
/// one; two samples give the straight line, three the parabola. Throws std::invalid_argument when there is no
/// sample or two have one time.
Eigen::VectorXd lagrange_weights(TimeNs stamp, const std::vector<TimeNs>& samples);

/// x(t) = sum xi_i x_i and P(t) = sum xi_i^2 P_i, equation (13.5), of samples whose errors are independent.
/// Outside of the samples' times the weights, and so the covariance, grow fast. Throws as lagrange_weights
/// does.
template <int Dim>
Gaussian<Dim> interpolate(const std::vector<Stamped<Gaussian<Dim>>>& samples, TimeNs stamp) {
  std::vector<TimeNs> stamps;
  stamps.reserve(samples.size());
  for (const auto& sample : samples) stamps.push_back(sample.stamp);
  const Eigen::VectorXd weights = lagrange_weights(stamp, stamps);
  Gaussian<Dim> result;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double weight = weights(static_cast<Eigen::Index>(i));
    result = weighted_sum<Dim>(1.0, result, weight, samples[i].value);
  }
  return result;
}

/// The same for poses: positions as above; turns on the manifold, R(t) = R_m Exp(sum xi_i Log(R_m^T R_i))
/// with m the middle one of the samples (the first of two), equation (13.6). The samples' turns differ by
/// less than half a turn.
template <class Space>
PoseEstimate<Space> interpolate(const std::vector<Stamped<PoseEstimate<Space>>>& samples, TimeNs stamp);

}  // namespace kinect_ekf_slam
