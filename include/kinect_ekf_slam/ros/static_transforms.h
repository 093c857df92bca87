#pragma once

#include <tf2/buffer_core.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/run_options.h"

namespace kinect_ekf_slam {

/// Makes the mountings of the parameters known to tf.
void add_static_transforms(const std::vector<StaticTransformOption>& transforms, const ros::Time& stamp,
                           tf2::BufferCore* buffer);

/// Where `source` is in `target` at `stamp`, or nothing when the buffer does not know.
std::optional<Eigen::Isometry3d> lookup_transform(const tf2::BufferCore& buffer, const std::string& target,
                                                  const std::string& source, const ros::Time& stamp);

}  // namespace kinect_ekf_slam
