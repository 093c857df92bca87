#pragma once

#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/run_options.h"

namespace kinect_ekf_slam {

/// One line that names the key, its value and what is allowed.
class ParameterError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What is documented of one parameter.
struct ParameterInfo {
  std::string key;  ///< group/name
  std::string default_value;
  std::string unit;
  std::string allowed;
  std::string meaning;
  bool required = false;
};

/// Reads the options from the groups of `yaml`. `unread` gets a line for each key that nothing reads, with
/// the one that may have been meant. Throws ParameterError for a missing required key, an unknown name, a
/// value out of range or of another type.
RunOptions read_parameters(const YAML::Node& yaml, std::vector<std::string>* unread);

/// All parameters there are, in the order of the groups.
std::vector<ParameterInfo> list_parameters();

}  // namespace kinect_ekf_slam
