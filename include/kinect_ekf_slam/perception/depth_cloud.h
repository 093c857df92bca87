#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "kinect_ekf_slam/perception/depth_noise.h"
#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/perception/support_plane.h"

namespace kinect_ekf_slam {

/// The readings of every `stride`-th pixel and row as points of the optical frame; z = 0: no reading.
struct DepthCloud {
  int stride = 1;
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector3d> points_in_optical;  ///< row after row

  int column_of(int index) const { return index % columns; }
  int row_of(int index) const { return index / columns; }
  bool has_reading(int index) const { return points_in_optical[index].z() > 0.0; }
};

/// Readings from `nearest` to `farthest` (m) of a depth picture in metres.
DepthCloud make_cloud(const cv::Mat& depth_in_metres, const PinholeCamera& camera, int stride, double nearest,
                      double farthest);

/// What hangs together above the plane.
struct Cluster {
  std::vector<int> indices;  ///< of the cloud's points
  Region region;             ///< in pixels of the picture
};

struct ClusterOptions {
  double smallest_height = 0.012;  ///< m above the plane; at a distance the depth's noise is added
  int smallest_size = 40;          ///< points
};

/// Clusters of points above the plane. Neighbours hang together when their depths differ by no more than
/// those of a surface seen at a grazing angle.
std::vector<Cluster> find_clusters(const DepthCloud& cloud, const PinholeCamera& camera,
                                   const SupportPlane& plane, const DepthNoise& noise,
                                   const ClusterOptions& options);

}  // namespace kinect_ekf_slam
