#include "kinect_ekf_slam/perception/depth_cloud.h"

#include <algorithm>
#include <cmath>

namespace kinect_ekf_slam {
namespace {

constexpr double kGrazingSlope = 3.7;  // tan of 75 degrees: change of depth over change of place
constexpr int kBridge = 2;             // missing neighbours that do not part a surface

class ClusterSearch {
 public:
  ClusterSearch(const DepthCloud& cloud, const PinholeCamera& camera, const DepthNoise& noise)
      : cloud_(cloud), noise_(noise), footprint_(cloud.stride / camera.fx) {}

  /// True for points that stand out of the plane.
  std::vector<char> above(const SupportPlane& plane, double smallest_height) const {
    std::vector<char> above(cloud_.points_in_optical.size(), 0);
    for (std::size_t i = 0; i < above.size(); ++i) {
      const Eigen::Vector3d& point = cloud_.points_in_optical[i];
      if (!(point.z() > 0.0)) continue;
      const double noise = noise_.step(point.z()) * std::abs(plane.up.dot(point)) / point.z();
      above[i] = plane.height_of(point) > smallest_height + 2.0 * noise ? 1 : 0;
    }
    return above;
  }

  /// Takes all that hangs together with `seed` out of `waiting`.
  Cluster grow(int seed, std::vector<char>* waiting) const {
    Cluster cluster;
    cluster.indices.push_back(seed);
    (*waiting)[seed] = 0;
    for (std::size_t next = 0; next < cluster.indices.size(); ++next) {
      const int index = cluster.indices[next];
      for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int neighbour = neighbour_of(index, du, dv);
        if (neighbour < 0 || (*waiting)[neighbour] == 0 || !connected(index, neighbour)) continue;
        (*waiting)[neighbour] = 0;
        cluster.indices.push_back(neighbour);
      }
    }
    cluster.region = region_of(cluster.indices);
    return cluster;
  }

 private:
  /// The first reading in that direction, over a few missing ones; -1: there is none.
  int neighbour_of(int index, int du, int dv) const {
    int column = cloud_.column_of(index);
    int row = cloud_.row_of(index);
    for (int i = 0; i <= kBridge; ++i) {
      column += du;
      row += dv;
      if (column < 0 || column >= cloud_.columns || row < 0 || row >= cloud_.rows) return -1;
      const int neighbour = row * cloud_.columns + column;
      if (cloud_.has_reading(neighbour)) return neighbour;
    }
    return -1;
  }

  bool connected(int a, int b) const {
    const double depth_a = cloud_.points_in_optical[a].z();
    const double depth_b = cloud_.points_in_optical[b].z();
    const double depth = std::min(depth_a, depth_b);
    const double allowed = kGrazingSlope * footprint_ * depth + 2.0 * noise_.step(depth);
    return std::abs(depth_a - depth_b) < allowed;
  }

  Region region_of(const std::vector<int>& indices) const {
    int left = cloud_.columns;
    int right = 0;
    int top = cloud_.rows;
    int bottom = 0;
    for (const int index : indices) {
      left = std::min(left, cloud_.column_of(index));
      right = std::max(right, cloud_.column_of(index));
      top = std::min(top, cloud_.row_of(index));
      bottom = std::max(bottom, cloud_.row_of(index));
    }
    const int stride = cloud_.stride;
    return {left * stride, top * stride, (right - left + 1) * stride, (bottom - top + 1) * stride};
  }

  const DepthCloud& cloud_;
  const DepthNoise& noise_;
  double footprint_;  ///< m between neighbours at depth 1 m
};

}  // namespace

DepthCloud make_cloud(const cv::Mat& depth_in_metres, const PinholeCamera& camera, int stride, double nearest,
                      double farthest) {
  DepthCloud cloud;
  cloud.stride = stride;
  cloud.columns = depth_in_metres.cols / stride;
  cloud.rows = depth_in_metres.rows / stride;
  cloud.points_in_optical.assign(static_cast<std::size_t>(cloud.columns) * cloud.rows,
                                 Eigen::Vector3d::Zero());
  std::size_t index = 0;
  for (int row = 0; row < cloud.rows; ++row) {
    for (int column = 0; column < cloud.columns; ++column, ++index) {
      const double depth = depth_in_metres.at<float>(row * stride, column * stride);
      if (depth >= nearest && depth <= farthest) {
        cloud.points_in_optical[index] = depth * camera.ray(column * stride, row * stride);
      }
    }
  }
  return cloud;
}

std::vector<Cluster> find_clusters(const DepthCloud& cloud, const PinholeCamera& camera,
                                   const SupportPlane& plane, const DepthNoise& noise,
                                   const ClusterOptions& options) {
  const ClusterSearch search(cloud, camera, noise);
  std::vector<char> waiting = search.above(plane, options.smallest_height);
  std::vector<Cluster> clusters;
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (waiting[i] == 0) continue;
    Cluster cluster = search.grow(static_cast<int>(i), &waiting);
    if (static_cast<int>(cluster.indices.size()) >= options.smallest_size) {
      clusters.push_back(std::move(cluster));
    }
  }
  return clusters;
}

}  // namespace kinect_ekf_slam
