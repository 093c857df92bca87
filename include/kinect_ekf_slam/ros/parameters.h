#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
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

/// Reads the options from the groups of `yaml`. Keys that nothing reads are returned in `unread`, as
/// group/name. Throws ParameterError for a missing required key, an unknown name, a value out of range or of
/// another type.
RunOptions read_parameters(const YAML::Node& yaml, std::vector<std::string>* unread);

/// All parameters there are, in the order of the groups.
std::vector<ParameterInfo> list_parameters();

/// `overlay` over `base`, key by key; lists and scalars replace.
YAML::Node merge_parameters(const YAML::Node& base, const YAML::Node& overlay);

/// Sets `group/key` to a value written as YAML. Throws ParameterError when the text is neither.
void set_parameter(const std::string& assignment, YAML::Node* yaml);

/// The text of config/slam.yaml, which every run starts from.
const char* default_parameters();

/// What an offline tool runs with: the defaults, the files of `configs` over them in their order, then the
/// assignments of `settings` (group/key=value). Keys that nothing reads go to `warn`, one line each.
/// Throws ParameterError.
RunOptions read_run_options(const std::vector<std::string>& configs, const std::vector<std::string>& settings,
                            const std::function<void(const std::string&)>& warn);

}  // namespace kinect_ekf_slam
