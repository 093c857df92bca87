#include "kinect_ekf_slam/ros/static_transforms.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2/exceptions.h>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/se3.h"
#include "kinect_ekf_slam/ros/conversions.h"

namespace kinect_ekf_slam {

void add_static_transforms(const std::vector<StaticTransformOption>& transforms, const ros::Time& stamp,
                           tf2::BufferCore* buffer) {
  for (const StaticTransformOption& option : transforms) {
    Eigen::Isometry3d parent_from_child = Eigen::Isometry3d::Identity();
    parent_from_child.translation() << option.xyz[0], option.xyz[1], option.xyz[2];
    parent_from_child.linear() = rotation_from_rpy(
        {radians(option.rpy_deg[0]), radians(option.rpy_deg[1]), radians(option.rpy_deg[2])});
    geometry_msgs::TransformStamped message;
    message.header.stamp = stamp;
    message.header.frame_id = option.parent;
    message.child_frame_id = option.child;
    message.transform = to_transform(parent_from_child);
    buffer->setTransform(message, "parameters", true);
  }
}

std::optional<Eigen::Isometry3d> lookup_transform(const tf2::BufferCore& buffer, const std::string& target,
                                                  const std::string& source, const ros::Time& stamp) {
  try {
    return to_eigen(buffer.lookupTransform(target, source, stamp).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

}  // namespace kinect_ekf_slam
