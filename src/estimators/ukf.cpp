#include "kinect_ekf_slam/estimators/ukf.h"

namespace kinect_ekf_slam {
namespace {

/// Lower triangular, root root^T = P to twelve digits: a P that rounding made semi-definite has one too.
Eigen::MatrixXd cholesky_root(Eigen::MatrixXd covariance) {
  constexpr double kRounding = 1e-12;
  covariance.diagonal() += kRounding * covariance.diagonal();
  return covariance.llt().matrixL();
}

}  // namespace

/// Sigma points of the pose's error; the noise of the step is added, as it arises at its end. The mean is
/// found on the manifold: the pose from which the errors of the moved ones average to nothing.
template <class Space>
void Ukf<Space>::predict(const MotionStep<Space>& step) {
  using Pose = typename Space::Pose;
  const Pose before = state_.map_from_base();
  const Eigen::MatrixXd root = cholesky_root(state_.pose_covariance());
  Pose mean = before * step.delta;
  UnscentedTransform moved;
  constexpr int kRounds = 2;  // the first finds the mean, the second the covariance about it
  for (int round = 0; round < kRounds; ++round) {
    moved = unscented_transform(root, UnscentedOptions(), [&](const Eigen::VectorXd& error) {
      const Pose start = Space::retract(before, local_from_error<Space>(before) * error);
      return Eigen::VectorXd(pose_error<Space>(mean, start * step.delta));
    });
    mean = Space::retract(mean, local_from_error<Space>(mean) * moved.mean);
  }
  const auto W = error_from_local<Space>(mean);
  state_.move({mean, moved.covariance + W * step.covariance * W.transpose()}, moved.slope);
}

template <class Space>
void Ukf<Space>::predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) {
  const int points = kPointDim * static_cast<int>(matches.size());
  const int dimension = kPoseDim + points;

  // The covariance of the pose and the landmarks observed, from their columns in that of the whole state_.
  Eigen::MatrixXd columns(state_.size(), dimension);
  std::vector<int> rows(matches.size() + 1, 0);  // in the state: of the pose, then of each landmark
  for (std::size_t j = 0; j < matches.size(); ++j) rows[j + 1] = state_.row(matches[j].landmark);
  const auto for_each_block = [&](const auto& visit) {
    visit(rows[0], 0, kPoseDim);
    for (std::size_t j = 1; j < rows.size(); ++j) {
      visit(rows[j], kPoseDim + kPointDim * (static_cast<int>(j) - 1), kPointDim);
    }
  };
  for_each_block([&](int row, int column, int size) {
    state_.covariance().copy_columns(row, columns.middleCols(column, size));
  });
  Eigen::MatrixXd observed(dimension, dimension);
  for_each_block([&](int row, int column, int size) {
    observed.middleRows(column, size) = columns.middleRows(row, size);
  });

  const typename Space::Pose& pose = state_.map_from_base();
  const auto transform =
      unscented_transform(cholesky_root(observed), UnscentedOptions(), [&](const Eigen::VectorXd& error) {
        const auto from_map =
            Space::retract(pose, local_from_error<Space>(pose) * error.template head<kPoseDim>()).inverse();
        Eigen::VectorXd seen(points);
        for (std::size_t j = 0; j < matches.size(); ++j) {
          const int row = kPointDim * static_cast<int>(j);
          const Point landmark =
              state_.landmark(matches[j].landmark) + error.template segment<kPointDim>(kPoseDim + row);
          seen.template segment<kPointDim>(row) = from_map * landmark;
        }
        return seen;
      });
  predicted->mean = transform.mean;
  predicted->covariance = transform.covariance;
  predicted->cross = columns * transform.slope.transpose();  // P_rest,a P_aa^-1 P_az for all rows at once
}

template class Ukf<Planar>;
template class Ukf<Spatial>;

}  // namespace kinect_ekf_slam
