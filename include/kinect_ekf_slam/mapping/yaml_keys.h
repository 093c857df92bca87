#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace kinect_ekf_slam {

/// What is wrong with the keys of one YAML map, not of those inside it: "line 7: key 'map' is given twice",
/// or "". YAML forbids such keys; yaml-cpp accepts them.
std::string repeated_key(const YAML::Node& map);

/// Likewise of a whole tree, whose depth and size are bounded: aliases can make a tree that contains itself,
/// or a short text that stands for more than any memory holds.
std::string repeated_key_within(const YAML::Node& tree);

}  // namespace kinect_ekf_slam
