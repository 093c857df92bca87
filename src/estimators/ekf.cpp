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

template class Ekf<Planar>;
template class Ekf<Spatial>;

}  // namespace kinect_ekf_slam
