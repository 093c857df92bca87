#pragma once

#include <memory>

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/estimators/kalman_slam.h"
#include "kinect_ekf_slam/estimators/options.h"

namespace kinect_ekf_slam {

/// The estimator that the options name, at `initial`, with an empty map.
template <class Space>
std::unique_ptr<SlamEstimator<Space>> make_estimator(const EstimatorOptions& options,
                                                     const AssociationOptions& association,
                                                     const PoseEstimate<Space>& initial);

/// The same, if it is a Kalman filter; else null.
template <class Space>
std::unique_ptr<KalmanSlam<Space>> make_kalman(const EstimatorOptions& options,
                                               const AssociationOptions& association,
                                               const PoseEstimate<Space>& initial);

}  // namespace kinect_ekf_slam
