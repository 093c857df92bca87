#pragma once

#include <vector>

#include "kinect_ekf_slam/perception/circle_fit.h"
#include "kinect_ekf_slam/perception/findings.h"

namespace kinect_ekf_slam {

/// One sweep of a planar scanner at the origin, from angle_min on (0: ahead, positive: to the left).
struct LaserScan {
  std::vector<float> ranges;     ///< m; what is not within the two bounds is no reading
  double angle_min = 0.0;        ///< rad
  double angle_increment = 0.0;  ///< rad
  double range_min = 0.0;        ///< m
  double range_max = 0.0;        ///< m

  double angle(std::size_t ray) const { return angle_min + static_cast<double>(ray) * angle_increment; }
  /// The last ray is the neighbour of the first one.
  bool is_full_turn() const;
};

struct LaserCylinderOptions {
  RadiusBounds radius{0.05, 0.20};  ///< m
  double range_sigma = 0.01;        ///< m, of the scanner
  double sigma_aside = 0.002;       ///< rad: half the width of a ray, about
  double jump = 0.15;               ///< m between neighbouring ranges: another surface
  int min_points = 5;               ///< rays that must meet it
  double min_arc = 1.57;            ///< rad that must be seen, as from the axis
  double max_misfit = 3.0;          ///< mean squared residual, in units of its variance
  double height_sigma = 0.05;       ///< m: the scan does not tell at which height the landmark is
};

/// Finds the circles that upright cylinders leave in a scan: runs of neighbouring rays without a jump that
/// stand free before their background, lie on a circle, and show its convex side. Refused are runs of the
/// size of a cylinder only; larger ones are walls.
Findings find_cylinders(const LaserScan& scan, const LaserCylinderOptions& options);

}  // namespace kinect_ekf_slam
