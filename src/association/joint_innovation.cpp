#include "kinect_ekf_slam/association/joint_innovation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {

template <class Space>
double JointInnovation<Space>::Increment::log_likelihood() const {
  return -0.5 * (squared_distance + log_determinant + kDim * std::log(2.0 * kPi));
}

/// The rows of L that border it: l = C^T L^-T, and the Cholesky factor of S_k - l l^T.
template <class Space>
std::optional<typename JointInnovation<Space>::Increment> JointInnovation<Space>::push(
    const Observation<Space>& observation, int landmark) {
  using PointMatrix = typename Space::PointMatrix;
  const int n = rows();
  if (L_.rows() < n + kDim) {
    const int capacity = std::max(2 * (n + kDim), 8 * kDim);
    L_.conservativeResize(capacity, capacity);
    whitened_.conservativeResize(capacity);
  }
  auto border = L_.block(n, 0, kDim, n);
  for (int j = 0; j < size(); ++j) {
    border.template middleCols<kDim>(kDim * j) = map_->cross_covariance(landmark, landmarks_[j]);
  }
  L_.topLeftCorner(n, n)
      .template triangularView<Eigen::Lower>()
      .transpose()
      .template solveInPlace<Eigen::OnTheRight>(border);
  const PointMatrix S =
      map_->covariance(landmark) + observation.covariance - (border * border.transpose()).eval();
  const Eigen::LLT<PointMatrix> cholesky(S);
  const typename Space::Point innovation =
      observation.position_in_base - map_->point_in_base(landmark) - border * whitened_.head(n);
  if (!innovation.allFinite() || cholesky.info() != Eigen::Success || !(cholesky.rcond() > kLeastRcond)) {
    return std::nullopt;
  }
  const typename Space::Point whitened = cholesky.matrixL().solve(innovation);
  L_.template block<kDim, kDim>(n, n) = cholesky.matrixL();
  whitened_.template segment<kDim>(n) = whitened;
  landmarks_.push_back(landmark);
  return Increment{whitened.squaredNorm(), 2.0 * cholesky.matrixLLT().diagonal().array().log().sum()};
}

template <class Space>
void JointInnovation<Space>::pop() {
  landmarks_.pop_back();
}

template class JointInnovation<Planar>;
template class JointInnovation<Spatial>;

}  // namespace kinect_ekf_slam
