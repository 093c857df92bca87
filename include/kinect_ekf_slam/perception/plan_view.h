#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinect_ekf_slam/perception/circle_fit.h"
#include "kinect_ekf_slam/perception/depth_cloud.h"
#include "kinect_ekf_slam/perception/depth_noise.h"
#include "kinect_ekf_slam/perception/support_plane.h"

namespace kinect_ekf_slam {

/// A point seen from above: X ahead of the camera, Y to its left, the camera's foot at the origin.
struct PlanPoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< m
  double height = 0.0;                              ///< m above the plane
  double depth = 0.0;                               ///< m
  int index = 0;                                    ///< of the cloud
};

/// The supporting plane as a map: from the optical frame to places on it and heights above it, and back.
class PlanView {
 public:
  explicit PlanView(const SupportPlane& plane);

  PlanPoint view(const Eigen::Vector3d& point_in_optical, int index) const;
  Eigen::Vector3d to_optical(const Eigen::Vector2d& place, double height) const;
  /// Columns: ahead, left, up, in the optical frame.
  const Eigen::Matrix3d& optical_from_plan() const { return optical_from_plan_; }

 private:
  Eigen::Matrix3d optical_from_plan_;
  double camera_height_;
};

struct UprightOutlineOptions {
  double smallest_height = 0.03;  ///< m that the surface must rise in one place
  double largest_base = 0.035;    ///< m above the object's lowest point that the surface may begin
  double window = 0.006;          ///< m in which its points lie; at a distance the depth's noise is added
  double roughness = 0.0005;      ///< m, of real surfaces
  double sigma_aside = 0.001;     ///< rad: where a pixel's depth belongs, about half a pixel
  /// Directions at each end that are left out. A Kinect compares windows of nine pixels: for half a window
  /// beyond an object's edge it still reports the object, and just inside the edge it reports the mean of one
  /// side.
  int edge = 6;
};

/// What a scanner that looks level along the plane would see of an object: for each direction the nearest
/// upright surface, from left to right. Tops, slopes and the insides of bowls and cups leave no trace in it.
/// `bin_width` in rad.
Outline upright_outline(const std::vector<PlanPoint>& points, double bin_width, const DepthNoise& noise,
                        const UprightOutlineOptions& options);

}  // namespace kinect_ekf_slam
