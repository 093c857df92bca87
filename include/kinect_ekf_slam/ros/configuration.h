#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/run_options.h"

namespace kinect_ekf_slam {

/// `overlay` over `base`, key by key; lists and scalars replace.
YAML::Node merge_parameters(const YAML::Node& base, const YAML::Node& overlay);

/// Sets `group/key` to a value written as YAML. Throws ParameterError when the text is neither.
void set_parameter(const std::string& assignment, YAML::Node* yaml);

/// The text of config/slam.yaml, which every run starts from.
const char* default_parameters();

/// What an offline tool runs with: the defaults, `files` over them in their order, then the
/// assignments of `settings` (group/key=value). Keys that nothing reads go to `warn`, one line each.
/// Throws ParameterError; it names the file whose value is at fault.
RunOptions read_run_options(const std::vector<std::string>& files, const std::vector<std::string>& settings,
                            const std::function<void(const std::string&)>& warn);

}  // namespace kinect_ekf_slam
