#pragma once

#include <Eigen/Core>

#include "kinect_ekf_slam/core/landmark.h"

namespace kinect_ekf_slam {

/// What the landmark sensor can see, and how well.
struct SensorOptions {
  /// Range gate in the optical frame; closed at both ends.
  double min_depth = 0.6;    ///< m
  double max_depth = 2.6;    ///< m
  double max_lateral = 2.5;  ///< m
  double range_scale = 1.0;  ///< true distance over measured distance
  /// 0: the measured distance is that to the point; 1: it is the depth, the distance along the optical axis.
  double depth_share = 0.0;

  int max_detections = 200;  ///< of one message that are used: the joint update grows with their cube

  double correlation_time = 0.0;  ///< s over which the errors of one landmark's sightings resemble each other

  /// `message`: the covariance that the detection carries, the model where it carries none.
  enum class NoiseSource { kMessage, kModel };
  NoiseSource noise_source = NoiseSource::kMessage;

  enum class Model { kDepthQuadratic, kRangeBearing };
  Model model = Model::kDepthQuadratic;
  /// `depth_quadratic`: variance a Z^2 + b Z + c, Z the depth (the report's equation 5).
  double depth_a = 0.00471429;  ///< -
  double depth_b = -0.0106429;  ///< m
  double depth_c = 0.00714286;  ///< m^2
  /// `range_bearing`: sigma of the range sqrt(noise^2 + (per_meter r)^2), of both angles alike.
  double range_noise = 0.05;            ///< m
  double range_noise_per_meter = 0.02;  ///< m/m
  double bearing_noise_deg = 2.0;       ///< deg
};

/// True inside the range gate.
bool in_range(const Detection& detection, const SensorOptions& options);

/// How much farther than along the optical axis a point in the optical frame is, less one: zero on the axis.
double obliquity(const Eigen::Vector3d& point_in_optical);

/// The detection with its distance from the sensor corrected by `range_scale` and `depth_share`:
/// range_scale (1 + depth_share obliquity) times the measured one.
Detection with_range_corrected(const Detection& detection, const SensorOptions& options);

/// R of a detection whose distance is corrected, m^2 in the base's axes; zero where the model does not hold.
Eigen::Matrix3d sighting_covariance(const Detection& corrected, const SensorOptions& options);

/// The detection with its distance corrected, and with the covariance to use.
Detection with_noise(const Detection& detection, const SensorOptions& options);

}  // namespace kinect_ekf_slam
