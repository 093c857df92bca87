#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/perception/picture.h"

namespace kinect_ekf_slam {

/// A place and how well it is known.
struct PlacedPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
};

/// How the camera moved between two pictures, and how well that is known.
struct CameraMotion {
  Eigen::Isometry3d second_from_first = Eigen::Isometry3d::Identity();
  /// Of a small motion of points in the second picture's axes: (translation m, rotation rad).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<bool> agrees;  ///< for each point: it is where this motion takes it
};

struct TwoViewOptions {
  double pixel_sigma = 1.0;         ///< pixels, of a keypoint on each axis
  double reprojection_error = 4.0;  ///< pixels; RANSAC's bound for points that agree with a motion
  int fewest = 8;                   ///< points that must agree
  double largest_share = 0.1;       ///< sigma of a triangulated depth over the depth
};

/// The motion that takes points, whose places are known in the first picture, to their pixels in the second:
/// P3P with RANSAC, then least squares weighted with the noise of pixels and places, of the points whose
/// error that noise allows. Nothing when too few agree.
std::optional<CameraMotion> find_motion(const std::vector<PlacedPoint>& points_in_first,
                                        const std::vector<Eigen::Vector2d>& pixels_in_second,
                                        const PinholeCamera& camera, const TwoViewOptions& options);

/// Where a point is, in the second picture's axes, that both pictures show. Least squares of the
/// reprojection (Hartley and Sturm, CVIU 68(2), 1997); the covariance is first order in the noise of the
/// pixels and of the motion. Nothing when it is behind a camera or its depth is too uncertain.
std::optional<PlacedPoint> triangulate(const Eigen::Vector2d& pixel_in_first,
                                       const Eigen::Vector2d& pixel_in_second, const CameraMotion& motion,
                                       const PinholeCamera& camera, const TwoViewOptions& options);

}  // namespace kinect_ekf_slam
