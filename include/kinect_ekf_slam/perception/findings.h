#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"

namespace kinect_ekf_slam {

/// A part of a picture, in pixels; of a scan, in rays, one row high.
struct Region {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
};

/// A landmark that a detector found, in the axes of its sensor: optical (X right, Y down, Z forward) for a
/// camera, X forward and Y left for a laser.
struct Finding {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
  Signature signature;
  double score = 1.0;  ///< confidence, 0 to 1
  Region region;       ///< where it is seen
};

/// What looked like a landmark and is none, or cannot be told to be one.
struct Refusal {
  std::string reason;  ///< a few words, for the debug picture and for counting
  Region region;
};

/// All that a detector has to say of one picture or scan.
struct Findings {
  std::vector<Finding> found;
  std::vector<Refusal> refused;
};

}  // namespace kinect_ekf_slam
