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
template <class Function>
void Ukf<Space>::transform(const std::vector<int>& landmarks, const Function& function,
                           PredictedMeasurement* predicted) const {
  // The covariance of the pose and the landmarks measured, from their columns in that of the whole state_.
  const Eigen::MatrixXd columns = state_.columns(landmarks);
  Eigen::MatrixXd measured(columns.cols(), columns.cols());
  Eigen::VectorXd points(columns.cols() - kPoseDim);
  GaussianState<Space>::for_each_block(landmarks, [&](int row, int in_part, int count) {
    measured.middleRows(in_part, count) = columns.middleRows(row, count);
  });
  for (std::size_t j = 0; j < landmarks.size(); ++j) {
    points.template segment<kPointDim>(kPointDim * static_cast<int>(j)) = state_.landmark(landmarks[j]);
  }
  const typename Space::Pose& pose = state_.map_from_base();
  const auto sent =
      unscented_transform(cholesky_root(measured), UnscentedOptions(), [&](const Eigen::VectorXd& error) {
        const auto moved =
            Space::retract(pose, local_from_error<Space>(pose) * error.template head<kPoseDim>());
        return Eigen::VectorXd(function(moved, Eigen::VectorXd(points + error.tail(points.size()))));
      });
  predicted->mean = sent.mean;
  predicted->covariance = sent.covariance;
  predicted->cross = columns * sent.slope.transpose();  // P_rest,a P_aa^-1 P_az for all rows at once
}

template <class Space>
void Ukf<Space>::predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) {
  std::vector<int> landmarks;
  landmarks.reserve(matches.size());
  for (const Match& match : matches) landmarks.push_back(match.landmark);
  const auto see = [](const typename Space::Pose& pose, const Eigen::VectorXd& points) {
    const typename Space::Pose from_map = pose.inverse();
    Eigen::VectorXd seen(points.size());
    for (Eigen::Index row = 0; row < points.size(); row += kPointDim) {
      seen.template segment<kPointDim>(row) = from_map * Point(points.template segment<kPointDim>(row));
    }
    return seen;
  };
  transform(landmarks, see, predicted);
}

template <class Space>
bool Ukf<Space>::predict_measurement(const PoseMeasurement<Space>& measurement, int landmark,
                                     PredictedMeasurement* predicted) {
  std::vector<int> landmarks;
  if (landmark >= 0) landmarks.push_back(landmark);
  bool is_defined = true;
  const auto measure = [&](const typename Space::Pose& pose, const Eigen::VectorXd& points) {
    const auto expected = measurement.expect(pose, points.size() == 0 ? Point(Point::Zero()) : Point(points));
    is_defined = is_defined && expected;
    return expected ? Eigen::VectorXd(-expected->innovation)
                    : Eigen::VectorXd(Eigen::VectorXd::Zero(predicted->mean.size()));
  };
  transform(landmarks, measure, predicted);
  return is_defined;
}

template class Ukf<Planar>;
template class Ukf<Spatial>;

}  // namespace kinect_ekf_slam
