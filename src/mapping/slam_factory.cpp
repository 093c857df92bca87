#include "kinect_ekf_slam/mapping/slam_factory.h"

#include <limits>
#include <stdexcept>
#include <utility>

#include "kinect_ekf_slam/estimators/factory.h"
#include "kinect_ekf_slam/mapping/multi_hypothesis.h"

namespace kinect_ekf_slam {

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
  LifeCycleOptions keeping = life_cycle;
  if (association.type == AssociationOptions::Type::kKnown) {
    keeping.merge_distance = 0.0;  // two names are two landmarks, and a name that is read is hardly nothing
    keeping.forget_after = std::numeric_limits<double>::infinity();
  }
  ManagedMap<Space> managed(std::move(filter), keeping);
  if (is_multi) return std::make_unique<MultiHypothesis<Space>>(managed, association);
  return std::make_unique<ManagedMap<Space>>(std::move(managed));
}

template std::unique_ptr<SlamEstimator<Planar>> make_slam<Planar>(const EstimatorOptions&,
                                                                  const AssociationOptions&,
                                                                  const LifeCycleOptions&,
                                                                  const PoseEstimate<Planar>&);
template std::unique_ptr<SlamEstimator<Spatial>> make_slam<Spatial>(const EstimatorOptions&,
                                                                    const AssociationOptions&,
                                                                    const LifeCycleOptions&,
                                                                    const PoseEstimate<Spatial>&);

}  // namespace kinect_ekf_slam
