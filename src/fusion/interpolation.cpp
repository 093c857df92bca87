#include "kinect_ekf_slam/fusion/interpolation.h"

#include <stdexcept>

#include "kinect_ekf_slam/estimators/pose_parts.h"

namespace kinect_ekf_slam {

Eigen::VectorXd lagrange_weights(TimeNs stamp, const std::vector<TimeNs>& samples) {
  if (samples.empty()) throw std::invalid_argument("interpolation: no samples given, at least one is needed");
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (std::size_t j = 0; j < samples.size(); ++j) {
      if (i == j) continue;
      if (samples[i] == samples[j])
        throw std::invalid_argument("interpolation: two samples have the same time");
      weights(static_cast<Eigen::Index>(i)) *=
          to_seconds(stamp - samples[j]) / to_seconds(samples[i] - samples[j]);
    }
  }
  return weights;
}

/// The error of each turn reaches the result through the logarithm and the exponential, whose derivatives are
/// J_l^-1 and J_l. With e the turns' errors in the map's axes and phi_i = Log(R_m^T R_i), to first order
/// e = e_m + R_m J_l(phi) sum xi_i J_l^-1(phi_i) R_m^T (e_i - e_m).
template <class Space>
PoseEstimate<Space> interpolate(const std::vector<Stamped<PoseEstimate<Space>>>& samples, TimeNs stamp) {
  using Pose = typename Space::Pose;
  using Turn = Eigen::Matrix<double, Space::kTurnDim, 1>;
  using TurnMatrix = Eigen::Matrix<double, Space::kTurnDim, Space::kTurnDim>;
  using PoseMatrix = typename Space::PoseMatrix;
  std::vector<TimeNs> stamps;
  stamps.reserve(samples.size());
  for (const auto& sample : samples) stamps.push_back(sample.stamp);
  const Eigen::VectorXd weights = lagrange_weights(stamp, stamps);

  const std::size_t middle = (samples.size() - 1) / 2;
  const Pose base = turn_of<Space>(samples[middle].value.map_from_base);
  typename Space::Point position = Space::Point::Zero();
  Turn turn = Turn::Zero();
  std::vector<Turn> turns;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Pose& pose = samples[i].value.map_from_base;
    const double weight = weights(static_cast<Eigen::Index>(i));
    turns.push_back(turn_log<Space>(base.inverse() * turn_of<Space>(pose)));
    position += weight * pose.translation();
    turn += weight * turns.back();
  }
  const TurnMatrix map_from_middle = turn_axes<Space>(base);
  const TurnMatrix out = map_from_middle * turn_jacobian<Space>(turn);
  std::vector<PoseMatrix> by_sample(samples.size(), PoseMatrix::Identity());
  TurnMatrix by_middle = TurnMatrix::Identity();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double weight = weights(static_cast<Eigen::Index>(i));
    const TurnMatrix by_turn =
        weight * out * turn_jacobian<Space>(turns[i]).inverse() * map_from_middle.transpose();
    by_sample[i] *= weight;
    by_sample[i].template bottomRightCorner<Space::kTurnDim, Space::kTurnDim>() = by_turn;
    by_middle -= by_turn;
  }
  by_sample[middle].template bottomRightCorner<Space::kTurnDim, Space::kTurnDim>() += by_middle;

  PoseEstimate<Space> result;
  result.map_from_base = pose_from_parts<Space>(position, base * turn_exp<Space>(turn));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    result.covariance += by_sample[i] * samples[i].value.covariance * by_sample[i].transpose();
  }
  result.covariance = PoseMatrix(result.covariance.template selfadjointView<Eigen::Lower>());
  return result;
}

template PoseEstimate<Planar> interpolate<Planar>(const std::vector<Stamped<PoseEstimate<Planar>>>&, TimeNs);
template PoseEstimate<Spatial> interpolate<Spatial>(const std::vector<Stamped<PoseEstimate<Spatial>>>&,
                                                    TimeNs);

}  // namespace kinect_ekf_slam
