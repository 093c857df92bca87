#include "kinect_ekf_slam/ros/detector_messages.h"

#include <cmath>
#include <stdexcept>

#include "kinect_ekf_slam/ros/conversions.h"

namespace kinect_ekf_slam {

LaserScan to_scan(const sensor_msgs::LaserScan& message) {
  if (!std::isfinite(message.angle_min) || !std::isfinite(message.angle_increment) ||
      message.angle_increment == 0.0F) {
    throw std::runtime_error("the scan's angles are no numbers");
  }
  if (!(message.range_min < message.range_max)) {
    throw std::runtime_error("the scan's range_min is not below its range_max");
  }
  LaserScan scan;
  scan.ranges = message.ranges;
  scan.angle_min = message.angle_min;
  scan.angle_increment = message.angle_increment;
  scan.range_min = message.range_min;
  scan.range_max = message.range_max;
  return scan;
}

LandmarkDetectionArray to_message(const Findings& findings, const std_msgs::Header& header) {
  LandmarkDetectionArray message;
  message.header = header;
  for (const Finding& finding : findings.found) {
    LandmarkDetection detection;
    detection.id = finding.signature.source_id;
    detection.label = finding.signature.label;
    detection.position = to_point(finding.position);
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(detection.covariance.data()) =
        finding.covariance;
    detection.radius = static_cast<float>(finding.signature.radius);
    detection.descriptor = finding.signature.descriptor;
    detection.score = static_cast<float>(finding.score);
    message.detections.push_back(std::move(detection));
  }
  return message;
}

}  // namespace kinect_ekf_slam
