#pragma once

#include <XmlRpcValue.h>
#include <ros/node_handle.h>
#include <yaml-cpp/yaml.h>

namespace kinect_ekf_slam {

/// What the parameter server holds below the node's namespace, as the YAML it came from. Names that belong to
/// other libraries (dynamic_reconfigure, diagnostic_updater) are left out.
YAML::Node parameters_of(const ros::NodeHandle& private_handle);

/// Throws ParameterError for a type that YAML does not have.
YAML::Node to_yaml(XmlRpc::XmlRpcValue value);

}  // namespace kinect_ekf_slam
