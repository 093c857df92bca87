#pragma once

#include <vector>

#include "kinect_ekf_slam/perception/circle_fit.h"
#include "kinect_ekf_slam/perception/depth_noise.h"
#include "kinect_ekf_slam/perception/plan_view.h"

namespace kinect_ekf_slam {

/// The part of an object that stands on a circle, from where it begins to where it ends.
struct CylinderWall {
  double base = 0.0;           ///< m above the plane
  double top = 0.0;            ///< m
  double taper = 0.0;          ///< change of radius over change of height
  double share_outside = 0.0;  ///< of the object's points up to the top: those outside the circle
  std::vector<int> indices;    ///< of the cloud: the points of the wall
};

/// Follows the wall from its lowest points upwards as long as it stays on the circle. `points` are the
/// object's; `footprint` is the angle between neighbours of the cloud, rad.
CylinderWall follow_wall(const std::vector<PlanPoint>& points, const Circle& circle, const DepthNoise& noise,
                         double footprint);

}  // namespace kinect_ekf_slam
