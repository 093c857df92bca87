#pragma once

#include <geometry_msgs/Point.h>

#include <cstddef>
#include <vector>

namespace kinect_ekf_slam {

/// A path kept for showing: a point each `step` metres, the oldest ones dropped.
class Trail {
 public:
  Trail(double step, std::size_t length) : step_(step), length_(length) {}

  /// True when the point was far enough from the last one to be kept.
  bool add(const geometry_msgs::Point& point);
  void clear() { points_.clear(); }
  const std::vector<geometry_msgs::Point>& points() const { return points_; }

 private:
  double step_;
  std::size_t length_;
  std::vector<geometry_msgs::Point> points_;
};

}  // namespace kinect_ekf_slam
