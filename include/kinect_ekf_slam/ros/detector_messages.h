#pragma once

#include <kinect_ekf_slam/LandmarkDetectionArray.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/Header.h>

#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/perception/laser_cylinder.h"

namespace kinect_ekf_slam {

/// Throws std::runtime_error when the angles are no numbers or the ranges leave nothing.
LaserScan to_scan(const sensor_msgs::LaserScan& message);

/// `header` is that of the picture or scan.
LandmarkDetectionArray to_message(const Findings& findings, const std_msgs::Header& header);

}  // namespace kinect_ekf_slam
