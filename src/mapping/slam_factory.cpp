#include "kinect_ekf_slam/mapping/slam_factory.h"

#include <limits>
#include <stdexcept>
#include <utility>

#include "kinect_ekf_slam/estimators/factory.h"
#include "kinect_ekf_slam/mapping/multi_hypothesis.h"

namespace kinect_ekf_slam {
namespace {

LifeCycleOptions keeping(LifeCycleOptions options, const AssociationOptions& association) {
  if (association.type == AssociationOptions::Type::kKnown) {
    options.merge_distance = 0.0;  // two names are two landmarks, and a name that is read is hardly nothing
    options.forget_after = std::numeric_limits<double>::infinity();
  }
  return options;
}

}  // namespace

template <class Space>
std::unique_ptr<SlamEstimator<Space>> make_slam(const EstimatorOptions& options,
                                                const AssociationOptions& association,
                                                const LifeCycleOptions& life_cycle,
                                                const PoseEstimate<Space>& initial) {
  const bool is_multi = association.type == AssociationOptions::Type::kMultiHypothesis;
  std::unique_ptr<KalmanSlam<Space>> filter = make_kalman<Space>(options, association, initial);
  if (filter == nullptr && is_multi) {
    throw std::invalid_argument(
        "association/type: multi_hypothesis given, allowed with estimator/type ekf, invariant_ekf, "
        "compressed_ekf and ukf only");
  }
  if (filter == nullptr) return make_estimator<Space>(options, association, initial);
  ManagedMap<Space> managed(std::move(filter), keeping(life_cycle, association));
  if (is_multi) return std::make_unique<MultiHypothesis<Space>>(managed, association);
  return std::make_unique<ManagedMap<Space>>(std::move(managed));
}

template <class Space>
std::unique_ptr<LocalMaps<Space>> make_local_maps(const EstimatorOptions& options,
                                                  const AssociationOptions& association,
                                                  const LifeCycleOptions& life_cycle,
                                                  const LocalMapOptions& local_maps,
                                                  const PoseEstimate<Space>& initial) {
  if (association.type == AssociationOptions::Type::kMultiHypothesis) {
    throw std::invalid_argument(
        "association/type: multi_hypothesis given, allowed for local maps: known, nearest_neighbor, jcbb");
  }
  if (make_kalman<Space>(options, association, initial) == nullptr) {
    throw std::invalid_argument(
        "estimator/type: no Kalman filter given, allowed for local maps: ekf, invariant_ekf, compressed_ekf, "
        "ukf");
  }
  const auto make_map = [=](const PoseEstimate<Space>& start) {
    return std::make_unique<ManagedMap<Space>>(make_kalman<Space>(options, association, start),
                                               keeping(life_cycle, association));
  };
  return std::make_unique<LocalMaps<Space>>(local_maps, make_map, make_associator<Space>(association),
                                            initial);
}

template std::unique_ptr<LocalMaps<Planar>> make_local_maps<Planar>(const EstimatorOptions&,
                                                                    const AssociationOptions&,
                                                                    const LifeCycleOptions&,
                                                                    const LocalMapOptions&,
                                                                    const PoseEstimate<Planar>&);
template std::unique_ptr<LocalMaps<Spatial>> make_local_maps<Spatial>(const EstimatorOptions&,
                                                                      const AssociationOptions&,
                                                                      const LifeCycleOptions&,
                                                                      const LocalMapOptions&,
                                                                      const PoseEstimate<Spatial>&);
template std::unique_ptr<SlamEstimator<Planar>> make_slam<Planar>(const EstimatorOptions&,
                                                                  const AssociationOptions&,
                                                                  const LifeCycleOptions&,
                                                                  const PoseEstimate<Planar>&);
template std::unique_ptr<SlamEstimator<Spatial>> make_slam<Spatial>(const EstimatorOptions&,
                                                                    const AssociationOptions&,
                                                                    const LifeCycleOptions&,
                                                                    const PoseEstimate<Spatial>&);

}  // namespace kinect_ekf_slam
