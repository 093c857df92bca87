#pragma once

#include <vector>

#include "kinect_ekf_slam/pipeline/slam_pipeline.h"

namespace kinect_ekf_slam::testing {

/// A fast robot with an all-round sensor, known identities, no conditioning in the way.
inline PipelineOptions wide_open() {
  PipelineOptions options;
  options.input.max_linear_speed = 10.0;
  options.input.max_angular_speed = 10.0;
  options.input.heading_source = HeadingSource::kOdometry;
  options.sensor.min_depth = -10.0;
  options.sensor.max_depth = 10.0;
  options.sensor.max_lateral = 10.0;
  options.association.type = AssociationOptions::Type::kKnown;
  options.association.gate_probability = 0.999;
  return options;
}

/// As a sensor at the robot's centre that looks ahead sees it.
inline Detection detection(double x, double y, int identity, double sigma = 0.05) {
  Detection detection;
  detection.position_in_base = {x, y, 0.0};
  detection.base_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  detection.position_in_optical = detection.base_from_optical.transpose() * detection.position_in_base;
  detection.covariance_in_base = sigma * sigma * Eigen::Matrix3d::Identity();
  detection.signature.source_id = identity;
  return detection;
}

inline SensorFrame odometry_frame(double time, double forward, double turn = 0.0) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.odometry.emplace();
  frame.odometry->linear.x() = forward;
  frame.odometry->angular.z() = turn;
  return frame;
}

inline SensorFrame gyro_frame(double time, double rate) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.gyro_rate = Eigen::Vector3d(0.0, 0.0, rate);
  return frame;
}

inline SensorFrame detection_frame(double time, const std::vector<Detection>& detections) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.detections = detections;
  return frame;
}

}  // namespace kinect_ekf_slam::testing
