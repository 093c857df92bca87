#pragma once

#include <memory>

#include "kinect_ekf_slam/mapping/life_cycle.h"
#include "kinect_ekf_slam/mapping/local_maps.h"

namespace kinect_ekf_slam {

/// The estimator with the keeper of its map, and with several hypotheses where the association asks for them.
/// Estimators that are no Kalman filters keep every landmark. Throws std::invalid_argument when there cannot
/// be several hypotheses of such a one.
template <class Space>
std::unique_ptr<SlamEstimator<Space>> make_slam(const EstimatorOptions& options,
                                                const AssociationOptions& association,
                                                const LifeCycleOptions& life_cycle,
                                                const PoseEstimate<Space>& initial);

/// The same in one local map after the other. Throws std::invalid_argument when the estimator is no Kalman
/// filter, or when several hypotheses are asked for.
template <class Space>
std::unique_ptr<LocalMaps<Space>> make_local_maps(const EstimatorOptions& options,
                                                  const AssociationOptions& association,
                                                  const LifeCycleOptions& life_cycle,
                                                  const LocalMapOptions& local_maps,
                                                  const PoseEstimate<Space>& initial);

}  // namespace kinect_ekf_slam
