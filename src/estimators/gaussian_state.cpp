#include "kinect_ekf_slam/estimators/gaussian_state.h"

#include <utility>

namespace kinect_ekf_slam {

template <class Space>
GaussianState<Space>::GaussianState(const PoseEstimate<Space>& initial) : covariance_(kPoseDim) {
  set_pose(initial);
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
  Eigen::MatrixXd columns(size(), row(static_cast<int>(landmarks.size())));
  for_each_block(landmarks, [&](int start, int in_part, int count) {
    covariance_.copy_columns(start, columns.middleCols(in_part, count));
  });
  return columns;
}

template <class Space>
void GaussianState<Space>::set_columns(const std::vector<int>& landmarks, const Eigen::MatrixXd& columns) {
  for_each_block(landmarks, [&](int start, int in_part, int count) {
    covariance_.set_columns(start, columns.middleCols(in_part, count));
  });
}

template <class Space>
GaussianState<Space> GaussianState<Space>::marginal(const std::vector<int>& landmarks,
                                                    const Eigen::MatrixXd& columns) const {
  GaussianState part({pose_, pose_covariance()});
  part.covariance_.resize(static_cast<int>(columns.cols()));
  for_each_block(landmarks, [&](int start, int in_part, int count) {
    part.covariance_.lower_rows(in_part, count) = columns.middleRows(start, count).leftCols(in_part + count);
  });
  for (const int i : landmarks) {
    part.infos_.push_back(infos_[i]);
    part.points_.push_back(points_[i]);
  }
  return part;
}

template <class Space>
void GaussianState<Space>::move(const PoseEstimate<Space>& moved, const PoseMatrix& F) {
  pose_ = moved.map_from_base;
  covariance_.lower_rows(0, kPoseDim) = moved.covariance;
  for (int i = 1; i < covariance_.panel_count(); ++i) {
    auto by_pose = covariance_.panel(i).template leftCols<kPoseDim>();
    for (int k = 0; k < by_pose.rows(); ++k) by_pose.row(k) = (by_pose.row(k) * F.transpose()).eval();
  }
}

template <class Space>
void GaussianState<Space>::set_pose(const PoseEstimate<Space>& pose) {
  pose_ = pose.map_from_base;
  covariance_.lower_rows(0, kPoseDim) = pose.covariance;
  for (int i = 1; i < covariance_.panel_count(); ++i) {
    covariance_.panel(i).template leftCols<kPoseDim>().setZero();
  }
}

template <class Space>
void GaussianState<Space>::correct(const Eigen::Ref<const Eigen::MatrixXd>& U) {
  covariance_.add_product(-1.0, U, U);
}

template <class Space>
void GaussianState<Space>::correct_pose(const Eigen::Ref<const Eigen::MatrixXd>& U) {
  const auto of_pose = U.template topRows<kPoseDim>();
  for (int i = 0; i < covariance_.panel_count(); ++i) {
    auto by_pose = covariance_.panel(i).template leftCols<kPoseDim>();
    by_pose.noalias() -= U.middleRows(covariance_.first_row(i), by_pose.rows()) * of_pose.transpose();
  }
}

template <class Space>
void GaussianState<Space>::add_landmark(LandmarkInfo info, const Point& landmark_in_map,
                                        const PointByPose& by_pose, const PointMatrix& independent) {
  const int start = size();
  covariance_.resize(start + kPointDim);
  auto rows = covariance_.lower_rows(start, kPointDim);
  const PointByPose cross = by_pose * pose_covariance();
  rows.template leftCols<kPoseDim>() = cross;
  for (int i = 0; i < landmark_count(); ++i) {
    rows.template middleCols<kPointDim>(row(i)) = by_pose * landmark_by_pose(i).transpose();
  }
  rows.template rightCols<kPointDim>() = cross * by_pose.transpose() + independent;
  infos_.push_back(std::move(info));
  points_.push_back(landmark_in_map);
}

/// Rows and columns move up, over the landmark's.
template <class Space>
void GaussianState<Space>::remove_landmark(int index) {
  for (int i = index; i + 1 < landmark_count(); ++i) {
    auto rows = covariance_.lower_rows(row(i), kPointDim);
    rows.template leftCols<kPoseDim>() = landmark_by_pose(i + 1);
    for (int j = 0; j <= i; ++j) {
      rows.template middleCols<kPointDim>(row(j)) = landmark_covariance(i + 1, j < index ? j : j + 1);
    }
  }
  infos_.erase(infos_.begin() + index);
  points_.erase(points_.begin() + index);
  covariance_.resize(size());
}

template <class Space>
SlamState<Space> GaussianState<Space>::snapshot() const {
  Eigen::VectorXd points(kPointDim * landmark_count());
  for (int i = 0; i < landmark_count(); ++i) points.template segment<kPointDim>(kPointDim * i) = points_[i];
  return {pose_, infos_, std::move(points), covariance_.dense()};
}

template <class Space>
void GaussianState<Space>::restore(const SlamState<Space>& state) {
  pose_ = state.map_from_base;
  points_.clear();
  for (Eigen::Index i = 0; i < state.landmarks_in_map.size(); i += kPointDim) {
    points_.push_back(state.landmarks_in_map.template segment<kPointDim>(i));
  }
  covariance_.set_dense(state.covariance);
  infos_ = state.infos;
}

template class GaussianState<Planar>;
template class GaussianState<Spatial>;

}  // namespace kinect_ekf_slam
