#pragma once

#include <optional>

#include "kinect_ekf_slam/perception/circle_fit.h"
#include "kinect_ekf_slam/perception/depth_cloud.h"
#include "kinect_ekf_slam/perception/depth_noise.h"
#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/perception/palette.h"
#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/perception/plan_view.h"
#include "kinect_ekf_slam/perception/support_plane.h"

namespace kinect_ekf_slam {

struct KinectCylinderOptions {
  double min_depth = 0.4;           ///< m
  double max_depth = 3.0;           ///< m
  RadiusBounds radius{0.02, 0.15};  ///< m
  double min_height = 0.05;         ///< m
  double max_height = 0.6;          ///< m
  double min_arc = 1.1;             ///< rad of the wall that must be seen, as from the axis
  double max_misfit = 2.5;          ///< mean squared residual of the outline, in units of its variance
  double max_taper = 0.12;          ///< change of radius over change of height
  double max_share_outside = 0.15;  ///< of the object's points up to its top that may lie outside the circle
  double edge_blur = 0.001;  ///< rad: how well an object's edge is known; moves radius and axis together
  double gravity_tolerance = 0.1;  ///< rad, of the plane's normal where gravity is known
  int stride = 1;                  ///< every so many pixels and rows are looked at
  SupportPlaneOptions plane;
  ClusterOptions clusters;
  UprightOutlineOptions outline;
  DepthNoise noise;
};

/// Finds cylinders that stand upright on the plane that most of the picture shows. A finding's position is
/// the point of its axis at half its height.
class KinectCylinderDetector {
 public:
  KinectCylinderDetector(const KinectCylinderOptions& options, const Palette& palette)
      : options_(options), palette_(palette) {}

  /// `up_in_optical`: where gravity says that up is; without it the options' guess counts. Throws
  /// PictureError when the picture has no depth or cannot be used.
  Findings detect(const RgbdPicture& picture,
                  const std::optional<Eigen::Vector3d>& up_in_optical = std::nullopt) const;

 private:
  KinectCylinderOptions options_;
  Palette palette_;
};

}  // namespace kinect_ekf_slam
