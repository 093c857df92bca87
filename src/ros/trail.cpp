#include "kinect_ekf_slam/ros/trail.h"

#include <cmath>

namespace kinect_ekf_slam {

bool Trail::add(const geometry_msgs::Point& point) {
  if (!points_.empty()) {
    const geometry_msgs::Point& last = points_.back();
    if (std::hypot(std::hypot(point.x - last.x, point.y - last.y), point.z - last.z) < step_) return false;
  }
  points_.push_back(point);
  // Half at a time: dropping one each step would move all the others each step.
  if (points_.size() > length_) points_.erase(points_.begin(), points_.begin() + (points_.size() + 1) / 2);
  return true;
}

}  // namespace kinect_ekf_slam
