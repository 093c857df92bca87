#pragma once

#include <Eigen/Core>

namespace kinect_ekf_slam {

/// How a structured-light camera errs in depth. It measures a disparity, in steps, so that the depth's step
/// and spread grow with its square. (Khoshelham and Oude Elberink, "Accuracy and resolution of Kinect depth
/// data", Sensors 12(2), 2012: 1.43e-3 / m for one pixel's spread, 2.85e-3 / m for the step.)
struct DepthNoise {
  double step_per_m = 2.85e-3;   ///< 1/m: the step at depth Z is this times Z^2
  double sigma_per_m = 1.43e-3;  ///< 1/m: of one pixel, like the step
  double calibration = 2e-3;     ///< share of the depth by which all of it may be off
  double pointing = 1.9e-3;      ///< rad by which all rays may be off: one pixel

  double step(double depth) const { return step_per_m * depth * depth; }
  double sigma(double depth) const { return sigma_per_m * depth * depth; }
  /// Variance of the mean of `count` readings of one depth, m^2. The step is common to all of them.
  double mean_variance(double depth, int count) const {
    return sigma(depth) * sigma(depth) / count + step(depth) * step(depth) / 12.0;
  }
  /// How far a place may be off because all of the camera is: its depth's scale and its rays, m^2.
  Eigen::Matrix3d camera_covariance(const Eigen::Vector3d& position_in_optical) const {
    const Eigen::Vector3d ray = position_in_optical.normalized();
    const double aside = pointing * position_in_optical.norm();
    return calibration * calibration * position_in_optical * position_in_optical.transpose() +
           aside * aside * (Eigen::Matrix3d::Identity() - ray * ray.transpose());
  }
};

}  // namespace kinect_ekf_slam
