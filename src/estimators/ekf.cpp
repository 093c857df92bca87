#include "kinect_ekf_slam/estimators/ekf.h"

namespace kinect_ekf_slam {

/// h(x), P H^T and H P H^T, equations (4.5) and (4.6). H is zero but for the pose and the landmark seen.
template <class Space>
void Ekf<Space>::predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) {
  const SymmetricMatrix& P = state_.covariance();
  predicted->cross.setZero();
  H_.resize(matches.size());
  for (std::size_t j = 0; j < matches.size(); ++j) {
    typename Space::Point expected;
    H_[j] = this->jacobian(state_.landmark(matches[j].landmark), &expected);
    predicted->mean.template segment<kPointDim>(kPointDim * j) = expected;
    auto columns = predicted->cross.template middleCols<kPointDim>(kPointDim * j);
    P.add_weighted_columns(0, H_[j].by_pose.transpose(), columns);
    P.add_weighted_columns(state_.row(matches[j].landmark), H_[j].by_landmark.transpose(), columns);
  }
  for (std::size_t j = 0; j < matches.size(); ++j) {
    predicted->covariance.template middleRows<kPointDim>(kPointDim * j).noalias() =
        H_[j].by_pose * predicted->cross.template topRows<kPoseDim>() +
        H_[j].by_landmark * predicted->cross.template middleRows<kPointDim>(state_.row(matches[j].landmark));
  }
}

/// The second order of a range is counted, equations (11.6) and (11.7): where it bends within the estimate's
/// uncertainty, the first alone would be wrong by more than it says.
template <class Space>
bool Ekf<Space>::predict_measurement(const PoseMeasurement<Space>& measurement, int landmark,
                                     PredictedMeasurement* predicted) {
  using PointByPose = typename Space::PointByPose;
  const typename Space::Pose& pose = state_.map_from_base();
  const auto expected = measurement.expect(pose, landmark < 0 ? Point::Zero() : state_.landmark(landmark));
  if (!expected) return false;
  const typename Space::PoseMatrix by_error = local_from_error<Space>(pose);
  located_ = {expected->by_pose * by_error, expected->by_point, landmark};

  const SymmetricMatrix& P = state_.covariance();
  predicted->mean = -expected->innovation;
  predicted->cross.setZero();
  P.add_weighted_columns(0, located_.by_pose.transpose(), predicted->cross);
  if (landmark >= 0) {
    P.add_weighted_columns(state_.row(landmark), located_.by_landmark.transpose(), predicted->cross);
  }
  predicted->covariance = located_.by_pose * predicted->cross.template topRows<kPoseDim>();
  if (landmark >= 0) {
    predicted->covariance +=
        located_.by_landmark * predicted->cross.template middleRows<kPointDim>(state_.row(landmark));
  }
  if (expected->bend) {
    const Jacobian W{expected->bend->by_pose * by_error, expected->bend->by_point};
    const PointByPose by_pose =
        landmark < 0 ? PointByPose(PointByPose::Zero()) : state_.landmark_by_pose(landmark);
    const PointMatrix of_landmark =
        landmark < 0 ? PointMatrix(PointMatrix::Zero()) : state_.landmark_covariance(landmark);
    const PointMatrix B = this->cross(W, W, state_.pose_covariance(), by_pose, by_pose, of_landmark);
    // More uncertain than far away, the beacon may lie in any direction.
    if (!(B.trace() * W.by_landmark.squaredNorm() < 1.0)) return false;
    predicted->mean(0) += 0.5 * B.trace();
    predicted->covariance(0, 0) += 0.5 * B.squaredNorm();
  }
  return true;
}

template class Ekf<Planar>;
template class Ekf<Spatial>;

}  // namespace kinect_ekf_slam
