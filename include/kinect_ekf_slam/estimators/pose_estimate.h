#pragma once

#include <Eigen/Core>

#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/models/motion.h"

namespace kinect_ekf_slam {

/// A pose with the covariance of its error: position, then rotation, both in the map's axes.
template <class Space>
struct PoseEstimate {
  typename Space::Pose map_from_base;
  typename Space::PoseMatrix covariance = Space::PoseMatrix::Zero();  ///< m^2, rad^2
};

/// d(error)/d(local perturbation): the error stands in the map's axes, equation (4.1). In the plane a turn
/// has no axes to turn.
template <class Space>
typename Space::PoseMatrix error_from_local(const typename Space::Pose& map_from_base) {
  typename Space::PoseMatrix transform = Space::PoseMatrix::Identity();
  transform.template topLeftCorner<Space::kPointDim, Space::kPointDim>() = map_from_base.rotation();
  if constexpr (Space::kTurnDim == Space::kPointDim) {
    transform.template bottomRightCorner<Space::kTurnDim, Space::kTurnDim>() = map_from_base.rotation();
  }
  return transform;
}

template <class Space>
typename Space::PoseMatrix local_from_error(const typename Space::Pose& map_from_base) {
  return error_from_local<Space>(map_from_base).transpose();  // it is a rotation
}

/// The error that leads from `from` to `to`: a shift and a turn along the map's axes.
template <class Space>
typename Space::PoseVector pose_error(const typename Space::Pose& from, const typename Space::Pose& to) {
  typename Space::PoseVector error = error_from_local<Space>(from) * (from.inverse() * to).log();
  error.template head<Space::kPointDim>() = to.translation() - from.translation();
  return error;
}

/// The prediction step of a pose, equations (4.2) to (4.4): x = f(x, u), P = F P F^T + W Q W^T. Returns F.
template <class Space>
typename Space::PoseMatrix predict_pose(const MotionStep<Space>& step, PoseEstimate<Space>* pose) {
  using PoseMatrix = typename Space::PoseMatrix;
  const typename Space::Pose moved = pose->map_from_base * step.delta;
  const PoseMatrix W = error_from_local<Space>(moved);
  PoseMatrix F = W * step.delta.inverse().adjoint() * local_from_error<Space>(pose->map_from_base);
  const PoseMatrix covariance = F * pose->covariance * F.transpose() + W * step.covariance * W.transpose();
  *pose = {moved, covariance.template selfadjointView<Eigen::Lower>()};
  return F;
}

}  // namespace kinect_ekf_slam
