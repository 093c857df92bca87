#include "kinect_ekf_slam/estimators/factory.h"

#include <stdexcept>
#include <utility>

#include "kinect_ekf_slam/estimators/compressed_ekf.h"
#include "kinect_ekf_slam/estimators/dead_reckoning.h"
#include "kinect_ekf_slam/estimators/ekf.h"
#include "kinect_ekf_slam/estimators/fast_slam.h"
#include "kinect_ekf_slam/estimators/invariant_ekf.h"
#include "kinect_ekf_slam/estimators/ukf.h"

namespace kinect_ekf_slam {

template <class Space>
std::unique_ptr<KalmanSlam<Space>> make_kalman(const EstimatorOptions& options,
                                               const AssociationOptions& association,
                                               const PoseEstimate<Space>& initial) {
  std::shared_ptr<const Associator<Space>> associator = make_associator<Space>(association);
  switch (options.type) {
    case EstimatorOptions::Type::kEkf:
      return std::make_unique<Ekf<Space>>(options, std::move(associator), initial);
    case EstimatorOptions::Type::kInvariantEkf:
      return std::make_unique<InvariantEkf<Space>>(options, std::move(associator), initial);
    case EstimatorOptions::Type::kCompressedEkf:
      return std::make_unique<CompressedEkf<Space>>(options, std::move(associator), initial);
    case EstimatorOptions::Type::kUkf:
      return std::make_unique<Ukf<Space>>(options, std::move(associator), initial);
    default:
      return nullptr;
  }
}

template <class Space>
std::unique_ptr<SlamEstimator<Space>> make_estimator(const EstimatorOptions& options,
                                                     const AssociationOptions& association,
                                                     const PoseEstimate<Space>& initial) {
  switch (options.type) {
    case EstimatorOptions::Type::kFastSlam1:
    case EstimatorOptions::Type::kFastSlam2:
      return std::make_unique<FastSlam<Space>>(options, make_associator<Space>(association), initial);
    case EstimatorOptions::Type::kDeadReckoning:
      return std::make_unique<DeadReckoning<Space>>(options, make_associator<Space>(association), initial);
    default:
      return make_kalman<Space>(options, association, initial);
  }
}

template std::unique_ptr<KalmanSlam<Planar>> make_kalman<Planar>(const EstimatorOptions&,
                                                                 const AssociationOptions&,
                                                                 const PoseEstimate<Planar>&);
template std::unique_ptr<KalmanSlam<Spatial>> make_kalman<Spatial>(const EstimatorOptions&,
                                                                   const AssociationOptions&,
                                                                   const PoseEstimate<Spatial>&);
template std::unique_ptr<SlamEstimator<Planar>> make_estimator<Planar>(const EstimatorOptions&,
                                                                       const AssociationOptions&,
                                                                       const PoseEstimate<Planar>&);
template std::unique_ptr<SlamEstimator<Spatial>> make_estimator<Spatial>(const EstimatorOptions&,
                                                                         const AssociationOptions&,
                                                                         const PoseEstimate<Spatial>&);

}  // namespace kinect_ekf_slam
