#pragma once

#include <memory>

#include "kinect_ekf_slam/mapping/life_cycle.h"

namespace kinect_ekf_slam {

/// The estimator with the keeper of its map, and with several hypotheses where the association asks for them.
/// Estimators that are no Kalman filters keep every landmark. Throws std::invalid_argument when there cannot
/// be several hypotheses of such a one.
template <class Space>
std::unique_ptr<SlamEstimator<Space>> make_slam(const EstimatorOptions& options,
                                                const AssociationOptions& association,
                                                const LifeCycleOptions& life_cycle,
                                                const PoseEstimate<Space>& initial);

}  // namespace kinect_ekf_slam
