#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"

namespace kinect_ekf_slam {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A planar estimate says nothing of z, roll and pitch: the floor is taken for flat to this variance, m^2 and
/// rad^2, so that no consumer reads certainty where nothing was measured.
constexpr double kPlanarVariance = 1e-4;

/// A pose in three dimensions, whatever space it was estimated in.
struct Pose3d {
  TimeNs stamp = 0;
  Eigen::Isometry3d map_from_base = Eigen::Isometry3d::Identity();
  /// REP-103: (x, y, z, roll, pitch, yaw) in the map's axes, m^2 and rad^2.
  Matrix6d covariance = Matrix6d::Identity() * kPlanarVariance;
};

/// The error of an estimate stands in the map's axes already: only its components find their places.
template <class Space>
Pose3d to_3d(TimeNs stamp, const PoseEstimate<Space>& estimate) {
  Pose3d pose;
  pose.stamp = stamp;
  pose.map_from_base = Space::to_3d(estimate.map_from_base);
  for (int i = 0; i < Space::kPoseDim; ++i) {
    for (int j = 0; j < Space::kPoseDim; ++j) {
      pose.covariance(Space::kPoseAxes[i], Space::kPoseAxes[j]) = estimate.covariance(i, j);
    }
  }
  return pose;
}

/// What a space takes of a pose.
template <class Space>
PoseEstimate<Space> to_estimate(const Pose3d& pose) {
  PoseEstimate<Space> estimate;
  estimate.map_from_base = Space::pose_from_3d(pose.map_from_base);
  for (int i = 0; i < Space::kPoseDim; ++i) {
    for (int j = 0; j < Space::kPoseDim; ++j) {
      estimate.covariance(i, j) = pose.covariance(Space::kPoseAxes[i], Space::kPoseAxes[j]);
    }
  }
  return estimate;
}

}  // namespace kinect_ekf_slam
