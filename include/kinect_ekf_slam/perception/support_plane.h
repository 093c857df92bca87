#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/perception/depth_noise.h"

namespace kinect_ekf_slam {

/// The plane on which objects stand, seen from above.
struct SupportPlane {
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();  ///< unit normal in the optical frame
  double camera_height = 0.0;                      ///< m, of the optical centre above the plane

  double height_of(const Eigen::Vector3d& point_in_optical) const {
    return up.dot(point_in_optical) + camera_height;
  }
};

struct SupportPlaneOptions {
  Eigen::Vector3d up_in_optical = -Eigen::Vector3d::UnitY();  ///< where up is thought to be
  double largest_tilt = 1.2;                                  ///< rad, between that and the plane's normal
  double tolerance = 0.008;                                   ///< m; at a distance the depth's noise is added
  double smallest_share = 0.1;                                ///< of the readings that must lie in the plane
  int iterations = 1000;                                      ///< at most
  std::uint64_t seed = 1;
};

/// The plane with the most points in it among those that lie level enough, by RANSAC (Fischler and Bolles,
/// 1981) and least squares over its points; none when too few lie in any.
std::optional<SupportPlane> find_support_plane(const std::vector<Eigen::Vector3d>& points_in_optical,
                                               const DepthNoise& noise, const SupportPlaneOptions& options);

}  // namespace kinect_ekf_slam
