#include "kinect_ekf_slam/estimators/gaussian_state.h"

#include <algorithm>
#include <utility>

namespace kinect_ekf_slam {

template <class Space>
GaussianState<Space>::GaussianState(const PoseEstimate<Space>& initial) : covariance_(kPoseDim, kPoseDim) {
  set_pose(initial);
}

template <class Space>
typename Space::PoseMatrix GaussianState<Space>::pose_covariance() const {
  return covariance_.topLeftCorner<kPoseDim, kPoseDim>().template selfadjointView<Eigen::Lower>();
}

template <class Space>
typename Space::PointMatrix GaussianState<Space>::landmark_covariance(int a, int b) const {
  if (a < b) return landmark_covariance(b, a).transpose();
  PointMatrix block = covariance_.block<kPointDim, kPointDim>(row(a), row(b));
  if (a == b) return PointMatrix(block.template selfadjointView<Eigen::Lower>());
  return block;
}

template <class Space>
std::vector<LandmarkEstimate<Space>> GaussianState<Space>::landmarks() const {
  std::vector<LandmarkEstimate<Space>> estimates;
  estimates.reserve(infos_.size());
  for (int i = 0; i < landmark_count(); ++i) {
    estimates.push_back({infos_[i], landmark(i), landmark_covariance(i)});
  }
  return estimates;
}

template <class Space>
Eigen::MatrixXd GaussianState<Space>::columns(const std::vector<int>& landmarks) const {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(size(), row(static_cast<int>(landmarks.size())));
  for_each_block(landmarks, [&](int start, int in_part, int count) {
    add_weighted_columns(start, Eigen::MatrixXd::Identity(count, count), columns.middleCols(in_part, count));
  });
  return columns;
}

template <class Space>
void GaussianState<Space>::set_columns(const std::vector<int>& landmarks, const Eigen::MatrixXd& columns) {
  auto P = lower();
  for_each_block(landmarks, [&](int start, int in_part, int count) {
    const auto below = P.rows() - start;
    P.block(start, 0, count, start) = columns.block(0, in_part, start, count).transpose();
    P.block(start, start, below, count) = columns.block(start, in_part, below, count);
  });
}

template <class Space>
GaussianState<Space> GaussianState<Space>::marginal(const std::vector<int>& landmarks) const {
  GaussianState part({pose_, pose_covariance()});
  const Eigen::MatrixXd columns = this->columns(landmarks);
  part.covariance_.resize(columns.cols(), columns.cols());
  for_each_block(landmarks, [&](int start, int in_part, int count) {
    part.covariance_.middleRows(in_part, count) = columns.middleRows(start, count);
  });
  part.points_.resize(kPointDim * landmarks.size());
  for (const int i : landmarks) {
    part.infos_.push_back(infos_[i]);
    part.set_landmark(part.landmark_count() - 1, landmark(i));
  }
  return part;
}

template <class Space>
void GaussianState<Space>::move(const PoseEstimate<Space>& moved, const PoseMatrix& F) {
  pose_ = moved.map_from_base;
  auto P = lower();
  P.template topLeftCorner<kPoseDim, kPoseDim>() = moved.covariance;
  auto landmark_rows = P.bottomLeftCorner(size() - kPoseDim, kPoseDim);
  for (int i = 0; i < landmark_rows.rows(); ++i) {
    landmark_rows.row(i) = (landmark_rows.row(i) * F.transpose()).eval();
  }
}

template <class Space>
void GaussianState<Space>::set_pose(const PoseEstimate<Space>& pose) {
  pose_ = pose.map_from_base;
  auto P = lower();
  P.leftCols(kPoseDim).setZero();
  P.template topLeftCorner<kPoseDim, kPoseDim>() = pose.covariance;
}

template <class Space>
void GaussianState<Space>::add_landmark(LandmarkInfo info, const Point& landmark_in_map,
                                        const typename Space::PointByPose& by_pose,
                                        const PointMatrix& independent) {
  const int old_size = size();
  const int new_size = old_size + kPointDim;
  if (covariance_.rows() < new_size) {
    const int capacity = std::max(2 * old_size, 64);
    covariance_.conservativeResize(capacity, capacity);
  }
  infos_.push_back(std::move(info));
  points_.conservativeResize(points_.size() + kPointDim);
  points_.tail<kPointDim>() = landmark_in_map;

  auto P = lower();
  auto cross = P.block(old_size, 0, kPointDim, old_size);
  cross.template leftCols<kPoseDim>() = by_pose * pose_covariance();
  cross.rightCols(old_size - kPoseDim) =
      by_pose * P.block(kPoseDim, 0, old_size - kPoseDim, kPoseDim).transpose();
  P.template bottomRightCorner<kPointDim, kPointDim>() =
      cross.template leftCols<kPoseDim>() * by_pose.transpose() + independent;
}

template <class Space>
void GaussianState<Space>::remove_landmark(int index) {
  SlamState<Space> state = snapshot();
  const int first = row(index);
  const int after = static_cast<int>(state.covariance.rows()) - first - kPointDim;
  const auto shift = [&](auto& matrix, int start) {  // rows up, over the landmark's
    matrix.middleRows(start, after) = matrix.middleRows(start + kPointDim, after).eval();
    matrix.conservativeResize(matrix.rows() - kPointDim, matrix.cols());
  };
  shift(state.landmarks_in_map, first - kPoseDim);
  shift(state.covariance, first);
  state.covariance.transposeInPlace();
  shift(state.covariance, first);
  state.infos.erase(state.infos.begin() + index);
  restore(state);
}

template <class Space>
SlamState<Space> GaussianState<Space>::snapshot() const {
  return {pose_, infos_, points_, lower().template selfadjointView<Eigen::Lower>()};
}

template <class Space>
void GaussianState<Space>::restore(const SlamState<Space>& state) {
  pose_ = state.map_from_base;
  points_ = state.landmarks_in_map;
  covariance_ = state.covariance;
  infos_ = state.infos;
}

template class GaussianState<Planar>;
template class GaussianState<Spatial>;

}  // namespace kinect_ekf_slam
