#pragma once

#include <utility>
#include <vector>

#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/smoothing/odometry_track.h"

namespace kinect_ekf_slam {

/// A path through poses of the batch optimum, the odometry between them.
template <class Space>
class SmoothedPath {
 public:
  using Pose = typename Space::Pose;
  using PoseMatrix = typename Space::PoseMatrix;
  /// Covariances of local perturbations pose * Exp(xi): of one pose, and of it with the next one.
  struct Knot {
    TimeNs stamp = 0;
    Pose map_from_base;
    PoseMatrix covariance = PoseMatrix::Identity();
    PoseMatrix with_next = PoseMatrix::Zero();  ///< E[xi xi_next^T]
  };

  /// At least one knot, stamps rising.
  SmoothedPath(OdometryTrack<Space> odometry, std::vector<Knot> knots)
      : odometry_(std::move(odometry)), knots_(std::move(knots)) {}

  /// The conditional mean and covariance between two knots; before the first and after the last as the
  /// odometry goes on.
  PoseEstimate<Space> at(TimeNs stamp) const;
  const OdometryTrack<Space>& odometry() const { return odometry_; }
  const std::vector<Knot>& knots() const { return knots_; }

 private:
  OdometryTrack<Space> odometry_;
  std::vector<Knot> knots_;
};

}  // namespace kinect_ekf_slam
