#include "kinect_ekf_slam/estimators/deferred_update.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kinect_ekf_slam {

template <class Space>
void DeferredUpdate<Space>::start(int landmarks, const std::vector<int>& active, Eigen::MatrixXd columns) {
  const bool is_whole = static_cast<int>(active.size()) == landmarks;
  const int rows = static_cast<int>(columns.cols());
  const int kept = is_whole ? 0 : rows;
  columns_ = std::move(columns);
  if (is_whole) columns_.resize(columns_.rows(), 0);
  start_.resize(kept, kept);
  if (!is_whole) {
    GaussianState<Space>::for_each_block(active, [&](int row, int in_part, int count) {
      start_.middleRows(in_part, count) = columns_.middleRows(row, count);
    });
  }
  phi_.setIdentity(rows, kept);
  psi_.setZero(kept, kept);
  theta_.setZero(kept);
}

template <class Space>
void DeferredUpdate<Space>::move(const PoseMatrix& F) {
  for (int i = 0; i < phi_.cols(); ++i) {
    phi_.col(i).template head<kPoseDim>() = (F * phi_.col(i).template head<kPoseDim>()).eval();
  }
}

template <class Space>
void DeferredUpdate<Space>::set_pose() {
  phi_.template topRows<kPoseDim>().setZero();
}

template <class Space>
void DeferredUpdate<Space>::add_landmark(const PointByPose& by_pose) {
  phi_.conservativeResize(phi_.rows() + kPointDim, phi_.cols());
  phi_.template bottomRows<kPointDim>().noalias() = by_pose * phi_.template topRows<kPoseDim>();
}

template <class Space>
void DeferredUpdate<Space>::correct(const Eigen::Ref<const Eigen::MatrixXd>& weighted,
                                    const Eigen::Ref<const Eigen::VectorXd>& whitened,
                                    const Eigen::Ref<const Eigen::MatrixXd>& L_H_phi, bool map_fixed) {
  if (map_fixed) {
    phi_.template topRows<kPoseDim>().noalias() -= weighted.template topRows<kPoseDim>() * L_H_phi;
    return;
  }
  psi_.template selfadjointView<Eigen::Lower>().rankUpdate(L_H_phi.transpose());
  theta_.noalias() += L_H_phi.transpose() * whitened;
  phi_.noalias() -= weighted * L_H_phi;
}

template <class Space>
void DeferredUpdate<Space>::apply(const std::vector<int>& active, const GaussianState<Space>& state,
                                  GaussianState<Space>* whole, PendingUpdates<Space>* pending) const {
  if (theta_.size() > 0) {  // (9.9); the landmarks of a are written below
    for (int i = 0; i < whole->landmark_count(); ++i) whole->set_landmark(i, landmark(*whole, i));
  }
  whole->set_map_from_base(state.map_from_base());
  for (int j = 0; j < state.landmark_count(); ++j) {
    if (active[j] == whole->landmark_count()) {
      whole->add_landmark(state.info(j), state.landmark(j), PointByPose::Zero(), PointMatrix::Zero());
    }
    whole->info(active[j]) = state.info(j);
    whole->set_landmark(active[j], state.landmark(j));
  }

  Eigen::MatrixXd columns(whole->size(), state.size());
  columns.topRows(columns_.rows()).noalias() = columns_ * phi_.transpose();  // (9.7)
  const Eigen::MatrixXd P_aa = state.covariance().dense();
  GaussianState<Space>::for_each_block(active, [&](int row, int in_part, int count) {
    columns.middleRows(row, count) = P_aa.middleRows(in_part, count);
  });
  whole->set_columns(active, columns);
  if (!psi_.isZero(0.0)) pending->add(columns_, psi_.template selfadjointView<Eigen::Lower>());
  pending->settle(active);
}

template <class Space>
typename Space::Point DeferredUpdate<Space>::landmark(const GaussianState<Space>& whole, int index) const {
  return whole.landmark(index) + columns_of(index) * theta_;
}

template <class Space>
typename Space::PointMatrix DeferredUpdate<Space>::landmark_covariance(const PointMatrix& at_start,
                                                                       int index) const {
  const auto columns = columns_of(index);
  const PointMatrix learnt = columns * (psi_.template selfadjointView<Eigen::Lower>() * columns.transpose());
  return at_start - PointMatrix(learnt.template selfadjointView<Eigen::Lower>());
}

template <class Space>
typename Space::PointByPose DeferredUpdate<Space>::landmark_by_pose(int index) const {
  return columns_of(index) * phi_.template topRows<kPoseDim>().transpose();
}

/// An error of standard deviation s that correlates with a by P_ba0 is moved by P_ba0 theta: by Cauchy and
/// Schwarz no more than s (theta^T P_aa0 theta)^1/2.
template <class Space>
double DeferredUpdate<Space>::largest_shift() const {
  return std::sqrt(std::max(0.0, theta_.dot(start_ * theta_)));
}

template class DeferredUpdate<Planar>;
template class DeferredUpdate<Spatial>;

}  // namespace kinect_ekf_slam
