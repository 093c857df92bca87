#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"
#include "kinect_ekf_slam/pipeline/pose_3d.h"

namespace kinect_ekf_slam {

/// A landmark of the map in three dimensions.
struct Landmark3d {
  int id = kNoId;
  int source_id = kNoId;
  std::string label;
  double radius = 0.0;  ///< m, 0: unknown
  std::uint32_t observations = 0;
  bool confirmed = true;  ///< false: it may yet turn out that nothing is there
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * kPlanarVariance;  ///< m^2
};

template <class Space>
Landmark3d to_3d(const LandmarkEstimate<Space>& estimate) {
  Landmark3d landmark;
  landmark.id = estimate.info.id;
  landmark.source_id = estimate.info.source_id;
  landmark.label = estimate.info.label();
  landmark.radius = estimate.info.radius;
  landmark.observations = estimate.info.observations;
  landmark.confirmed = estimate.info.confirmed;
  landmark.position_in_map = Space::to_3d(estimate.position_in_map);
  landmark.covariance.template topLeftCorner<Space::kPointDim, Space::kPointDim>() = estimate.covariance;
  return landmark;
}

}  // namespace kinect_ekf_slam
