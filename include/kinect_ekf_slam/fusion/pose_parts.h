#pragma once

#include <Eigen/Core>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

// A pose's position and turn apart, whatever the space. A turn is a pose without translation.

template <class Space>
using TurnVector = Eigen::Matrix<double, Space::kTurnDim, 1>;
template <class Space>
using TurnMatrix = Eigen::Matrix<double, Space::kTurnDim, Space::kTurnDim>;

template <class Space>
typename Space::Pose translation_by(const typename Space::Point& shift) {
  typename Space::PoseVector twist = Space::PoseVector::Zero();
  twist.template head<Space::kPointDim>() = shift;
  return Space::Pose::exp(twist);
}

template <class Space>
typename Space::Pose turn_of(const typename Space::Pose& pose) {
  return translation_by<Space>(-pose.translation()) * pose;
}

template <class Space>
typename Space::Pose pose_from_parts(const typename Space::Point& position,
                                     const typename Space::Pose& turn) {
  return translation_by<Space>(position) * turn;
}

template <class Space>
typename Space::Pose turn_exp(const TurnVector<Space>& turn) {
  typename Space::PoseVector twist = Space::PoseVector::Zero();
  twist.template tail<Space::kTurnDim>() = turn;
  return Space::Pose::exp(twist);
}

template <class Space>
TurnVector<Space> turn_log(const typename Space::Pose& turn) {
  return turn.log().template tail<Space::kTurnDim>();
}

/// How a turn's vector changes its axes under the pose: in the plane not at all.
template <class Space>
TurnMatrix<Space> turn_axes(const typename Space::Pose& pose) {
  if constexpr (Space::kTurnDim == 1) {
    return TurnMatrix<Space>::Identity();
  } else {
    return pose.rotation();
  }
}

/// J_l(phi) with Exp(phi + d) = Exp(J_l d) Exp(phi) to first order. (Sola et al., equation 145: it is the
/// matrix by which Exp moves the translation of a twist.)
template <class Space>
TurnMatrix<Space> turn_jacobian(const TurnVector<Space>& turn) {
  TurnMatrix<Space> jacobian = TurnMatrix<Space>::Identity();
  if constexpr (Space::kTurnDim == Space::kPointDim) {
    for (int axis = 0; axis < Space::kTurnDim; ++axis) {
      typename Space::PoseVector twist;
      twist << Space::Point::Unit(axis), turn;
      jacobian.col(axis) = Space::Pose::exp(twist).translation();
    }
  }
  return jacobian;
}

/// The pose after an error in the map's axes: a shift, and a turn about its own place.
template <class Space>
typename Space::Pose moved_by_error(const typename Space::Pose& pose,
                                    const typename Space::PoseVector& error) {
  return pose_from_parts<Space>(
      pose.translation() + error.template head<Space::kPointDim>(),
      turn_exp<Space>(error.template tail<Space::kTurnDim>()) * turn_of<Space>(pose));
}

}  // namespace kinect_ekf_slam
