#pragma once

#include <Eigen/Core>

#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"

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

/// d(X p)/d(error of X): a shift, and a turn about X's own place. `moved_point` is X p.
template <class Space>
typename Space::PointByPose point_by_error(const typename Space::Pose& transform,
                                           const typename Space::Point& moved_point) {
  typename Space::PointByPose jacobian;
  jacobian << Space::PointMatrix::Identity(),
      Space::by_turn(typename Space::Point(moved_point - transform.translation()));
  return jacobian;
}

/// How the error of a product of two poses depends on those of its factors, each in the axes of its own map.
template <class Space>
struct ProductJacobian {
  typename Space::PoseMatrix by_left = Space::PoseMatrix::Identity();
  typename Space::PoseMatrix by_right = Space::PoseMatrix::Zero();

  ProductJacobian(const typename Space::Pose& left, const typename Space::Pose& right) {
    constexpr int kPoints = Space::kPointDim;
    constexpr int kTurns = Space::kTurnDim;
    by_left.template topRows<kPoints>() = point_by_error<Space>(left, left * right.translation());
    by_right.template topLeftCorner<kPoints, kPoints>() = left.rotation();
    by_right.template bottomRightCorner<kTurns, kTurns>() = turn_axes<Space>(left);
  }
};

/// The product of two poses whose errors are independent.
template <class Space>
PoseEstimate<Space> product(const PoseEstimate<Space>& left, const PoseEstimate<Space>& right) {
  const ProductJacobian<Space> J(left.map_from_base, right.map_from_base);
  const typename Space::PoseMatrix covariance = J.by_left * left.covariance * J.by_left.transpose() +
                                                J.by_right * right.covariance * J.by_right.transpose();
  return {left.map_from_base * right.map_from_base, covariance.template selfadjointView<Eigen::Lower>()};
}

}  // namespace kinect_ekf_slam
