#include "kinect_ekf_slam/models/sensor_model.h"

#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

/// Covariance in the optical frame, or zero where the model does not hold.
Eigen::Matrix3d model_covariance(const Eigen::Vector3d& point_in_optical, const SensorOptions& options) {
  if (options.model == SensorOptions::Model::kDepthQuadratic) {
    const double depth = point_in_optical.z();
    const double variance = (options.depth_a * depth + options.depth_b) * depth + options.depth_c;
    return variance * Eigen::Matrix3d::Identity();
  }
  const double range = point_in_optical.norm();
  if (!(range > 0.0)) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d ray = point_in_optical / range;
  const Eigen::Matrix3d along = ray * ray.transpose();
  const double across_sigma = range * radians(options.bearing_noise_deg);
  const double range_variance =
      std::pow(options.range_noise, 2) + std::pow(options.range_noise_per_meter * range, 2);
  return range_variance * along + across_sigma * across_sigma * (Eigen::Matrix3d::Identity() - along);
}

}  // namespace

bool in_range(const Detection& detection, const SensorOptions& options) {
  const Eigen::Vector3d& point = detection.position_in_optical;
  return point.z() >= options.min_depth && point.z() <= options.max_depth &&
         std::abs(point.x()) <= options.max_lateral;
}

double obliquity(const Eigen::Vector3d& point_in_optical) {
  constexpr double kLargest = 10.0;  // beyond that it says nothing of the distance
  const double depth = point_in_optical.z();
  const double distance = point_in_optical.norm();
  return distance >= kLargest * depth ? kLargest - 1.0 : distance / depth - 1.0;
}

Detection with_range_corrected(const Detection& detection, const SensorOptions& options) {
  const double factor =
      options.range_scale * (1.0 + options.depth_share * obliquity(detection.position_in_optical));
  Detection corrected = detection;
  const Eigen::Vector3d shift_in_optical = (factor - 1.0) * detection.position_in_optical;
  corrected.position_in_optical += shift_in_optical;
  corrected.position_in_base += detection.base_from_optical * shift_in_optical;
  return corrected;
}

Eigen::Matrix3d sighting_covariance(const Detection& corrected, const SensorOptions& options) {
  const bool carries_none = corrected.covariance_in_base.isZero(0.0);
  if (options.noise_source == SensorOptions::NoiseSource::kMessage && !carries_none) {
    return corrected.covariance_in_base;
  }
  return corrected.base_from_optical * model_covariance(corrected.position_in_optical, options) *
         corrected.base_from_optical.transpose();
}

Detection with_noise(const Detection& detection, const SensorOptions& options) {
  Detection corrected = with_range_corrected(detection, options);
  corrected.covariance_in_base = sighting_covariance(corrected, options);
  return corrected;
}

}  // namespace kinect_ekf_slam
