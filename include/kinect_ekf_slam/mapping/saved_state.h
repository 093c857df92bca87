#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// The whole state of an estimator, in a form that a file can hold whatever the space.
struct SavedState {
  std::string space;  ///< the space's kName
  TimeNs stamp = 0;
  Eigen::VectorXd pose;  ///< as the space's to_vector writes it
  std::vector<LandmarkInfo> infos;
  Eigen::MatrixXd landmarks_in_map;  ///< m, one a row
  Eigen::MatrixXd covariance;        ///< rows and columns: pose, then the landmarks
};

}  // namespace kinect_ekf_slam
