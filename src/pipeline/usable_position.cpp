#include "kinect_ekf_slam/pipeline/usable_position.h"

#include "kinect_ekf_slam/pipeline/is_covariance.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kFarthest = 1e8;   // m; no frame on the Earth has larger numbers
constexpr double kLeastSure = 1e6;  // m^2; more is no knowledge

}  // namespace

bool is_usable(const GlobalPosition& position) {
  const bool is_sure = position.map_from_base
                           ? is_covariance(position.covariance)
                           : is_covariance(Eigen::Matrix3d(position.covariance.topLeftCorner<3, 3>()));
  return is_sure && (position.position_in_map.array().abs() < kFarthest).all() &&
         position.antenna_in_base.allFinite() &&
         (!position.map_from_base || position.map_from_base->coeffs().allFinite());
}

bool is_usable(const BeaconRange& range) {
  return range.range >= 0.0 && range.range < kFarthest && range.variance > 0.0 &&
         range.variance < kLeastSure && range.receiver_in_base.allFinite();
}

}  // namespace kinect_ekf_slam
