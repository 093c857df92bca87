#include "kinect_ekf_slam/fusion/beacon_localization.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <utility>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/estimators/pose_parts.h"
#include "kinect_ekf_slam/models/pose_measurement.h"

namespace kinect_ekf_slam {

template <class Space>
BeaconLocalization<Space>::BeaconLocalization(Beacons beacons, const BeaconLocalizationOptions& options,
                                              TimeNs stamp, const Position& position)
    : beacons_(std::move(beacons)),
      options_(options),
      gate_(chi_square_quantile(options.gate_probability, 1)),
      now_(stamp) {
  state_.covariance.setIdentity();  // of the velocity, (m/s)^2
  state_.mean.template head<kDim>() = position.mean;
  state_.covariance.template topLeftCorner<kDim, kDim>() = position.covariance;
}

/// Nearly constant velocity: x' = x + v dt, and what a white acceleration of density q adds. (Bar-Shalom, Li
/// and Kirubarajan, section 6.2.2.)
template <class Space>
void BeaconLocalization<Space>::move_on(TimeNs stamp) {
  const double dt = to_seconds(stamp - now_);
  if (dt <= 0.0) return;
  now_ = stamp;
  using Matrix = typename Gaussian<kStateDim>::Matrix;
  const auto unit = Space::PointMatrix::Identity();
  const double q = options_.acceleration_noise * options_.acceleration_noise;
  Matrix F = Matrix::Identity();
  F.template topRightCorner<kDim, kDim>() = dt * unit;
  Matrix Q;
  Q << q * dt * dt * dt / 3.0 * unit, q * dt * dt / 2.0 * unit, q * dt * dt / 2.0 * unit, q * dt * unit;
  state_ = predicted<kStateDim>(state_, F, Gaussian<kStateDim>::Vector::Zero(), Q);
}

template <class Space>
std::optional<typename BeaconLocalization<Space>::Linearized> BeaconLocalization<Space>::linearize(
    const BeaconRange& range, const typename Space::Point& position) const {
  const auto beacon = beacons_.find(range.beacon);
  if (beacon == beacons_.end()) return std::nullopt;
  BeaconRange at_center = range;
  at_center.receiver_in_base.setZero();  // without a heading there is no lever arm
  const auto expected =
      RangeMeasurement<Space>(at_center, 0.0).expect(translation_by<Space>(position), beacon->second.mean);
  if (!expected) return std::nullopt;
  const Row by_beacon = expected->by_point;
  return Linearized{expected->innovation(0), expected->by_pose.template leftCols<kDim>(),
                    range.variance + (by_beacon * beacon->second.covariance).dot(by_beacon)};
}

template <class Space>
typename BeaconLocalization<Space>::Report BeaconLocalization<Space>::update(
    TimeNs stamp, const std::vector<BeaconRange>& ranges) {
  move_on(stamp);
  Report report;
  std::vector<BeaconRange> used;
  for (const BeaconRange& range : ranges) {
    const auto seen = linearize(range, state_.mean.template head<kDim>());
    if (!seen) {
      ++report.unknown;
      continue;
    }
    Eigen::Matrix<double, 1, kStateDim> H = Eigen::Matrix<double, 1, kStateDim>::Zero();
    H.template leftCols<kDim>() = seen->by_position;
    const Eigen::Matrix<double, 1, 1> innovation(seen->innovation);
    Gaussian<kStateDim> corrected = state_;
    const auto fit =
        correct<kStateDim, 1>(innovation, H, Eigen::Matrix<double, 1, 1>(seen->variance), &corrected);
    if (!fit || fit->squared_distance >= gate_) {
      ++report.refused;
      continue;
    }
    state_ = corrected;
    used.push_back(range);
  }
  report.fix = fix(used);
  return report;
}

/// Least squares of the ranges alone, by Gauss and Newton from the filter's position.
template <class Space>
std::optional<typename BeaconLocalization<Space>::Position> BeaconLocalization<Space>::fix(
    const std::vector<BeaconRange>& ranges) const {
  constexpr int kMostRounds = 30;
  constexpr double kSettled = 1e-6;  // m
  if (ranges.size() < static_cast<std::size_t>(kDim)) return std::nullopt;
  Position fix = position();
  for (int round = 0; round < kMostRounds; ++round) {
    typename Space::PointMatrix information = Space::PointMatrix::Zero();
    typename Space::Point pull = Space::Point::Zero();
    for (const BeaconRange& range : ranges) {
      const auto seen = linearize(range, fix.mean);
      if (!seen) return std::nullopt;
      information += seen->by_position.transpose() * seen->by_position / seen->variance;
      pull += seen->by_position.transpose() * seen->innovation / seen->variance;
    }
    const Eigen::SelfAdjointEigenSolver<typename Space::PointMatrix> axes(information);
    const double worst_variance = 1.0 / axes.eigenvalues().minCoeff();
    const double largest = options_.max_fix_sigma * options_.max_fix_sigma;
    if (!(worst_variance > 0.0 && worst_variance <= largest)) return std::nullopt;
    const Eigen::LLT<typename Space::PointMatrix> factor(information);
    const typename Space::Point step = factor.solve(pull);
    fix.mean += step;
    fix.covariance = factor.solve(Space::PointMatrix::Identity());
    if (step.norm() < kSettled) return fix;
  }
  return std::nullopt;
}

template class BeaconLocalization<Planar>;
template class BeaconLocalization<Spatial>;

}  // namespace kinect_ekf_slam
