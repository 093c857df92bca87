#include "kinect_ekf_slam/ros/configuration.h"

#include <filesystem>
#include <fstream>

#include "kinect_ekf_slam/mapping/yaml_keys.h"
#include "kinect_ekf_slam/ros/parameters.h"

namespace kinect_ekf_slam {
namespace {

/// The text of a file of parameters. Throws ParameterError when there is none, or more than a person writes.
std::string config_text(const std::string& file) {
  constexpr std::streamsize kMost = 1 << 20;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ParameterError(file + ": cannot be read");
  std::string text(kMost + 1, '\0');
  stream.read(text.data(), kMost + 1);  // a device never ends
  if (stream.gcount() > kMost) {
    throw ParameterError(file + ": allowed: no more than " + std::to_string(kMost) + " bytes");
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

struct Config {
  std::string file;
  YAML::Node yaml;
};

/// Throws ParameterError.
Config read_config(const std::string& file) {
  std::error_code unreadable;  // is told below
  if (std::filesystem::is_directory(file, unreadable)) throw ParameterError(file + ": is a folder");
  try {
    const YAML::Node yaml = YAML::Load(config_text(file));
    if (!yaml.IsMap() && !yaml.IsNull()) throw ParameterError(file + ": not a YAML map of parameter groups");
    const std::string fault = repeated_key_within(yaml);
    if (!fault.empty()) throw ParameterError(std::string(file).append(": ").append(fault));
    return {file, yaml};
  } catch (const YAML::Exception& error) {
    throw ParameterError(file + ": not YAML: " + error.what());
  }
}

bool has(const YAML::Node& yaml, const std::string& key) {
  const auto slash = key.find('/');
  if (!yaml.IsMap()) return false;
  if (slash == std::string::npos) return static_cast<bool>(yaml[key]);
  const YAML::Node group = yaml[key.substr(0, slash)];
  return group && group.IsMap() && group[key.substr(slash + 1)];
}

/// "FILE: " where a file has given the key that `line` begins with; "" where a setting or the defaults did.
std::string source_of(const std::string& line, const std::vector<Config>& configs,
                      const std::vector<std::string>& settings) {
  const std::string key = line.substr(0, line.find_first_of(":, "));
  for (const std::string& setting : settings) {
    if (setting.rfind(key + "=", 0) == 0) return "";
  }
  for (auto config = configs.rbegin(); config != configs.rend(); ++config) {
    if (has(config->yaml, key)) return config->file + ": ";
  }
  return "";
}

}  // namespace

YAML::Node merge_parameters(const YAML::Node& base, const YAML::Node& overlay) {
  if (!base.IsMap() || !overlay.IsMap()) return overlay.IsDefined() && !overlay.IsNull() ? overlay : base;
  YAML::Node merged = YAML::Clone(base);
  for (const auto& entry : overlay) {
    const auto key = entry.first.as<std::string>();
    merged[key] = merged[key] ? merge_parameters(merged[key], entry.second) : entry.second;
  }
  return merged;
}

void set_parameter(const std::string& assignment, YAML::Node* yaml) {
  const auto equals = assignment.find('=');
  const auto slash = assignment.find('/');
  if (equals == std::string::npos || equals == 0) {
    throw ParameterError("'" + assignment + "' given, allowed: group/key=value");
  }
  const std::string key = assignment.substr(0, equals);
  try {
    const YAML::Node value = YAML::Load(assignment.substr(equals + 1));
    if (slash < equals) {
      (*yaml)[key.substr(0, slash)][key.substr(slash + 1)] = value;
    } else {
      (*yaml)[key] = value;
    }
  } catch (const YAML::Exception&) {
    throw ParameterError(key + ": '" + assignment.substr(equals + 1) + "' is not YAML");
  }
}

RunOptions read_run_options(const std::vector<std::string>& files, const std::vector<std::string>& settings,
                            const std::function<void(const std::string&)>& warn) {
  YAML::Node yaml = YAML::Load(default_parameters());
  std::vector<Config> configs;
  for (const std::string& file : files) {
    configs.push_back(read_config(file));
    yaml = merge_parameters(yaml, configs.back().yaml);
  }
  for (const std::string& setting : settings) set_parameter(setting, &yaml);
  std::vector<std::string> unread;
  RunOptions options;
  try {
    options = read_parameters(yaml, &unread);
  } catch (const ParameterError& error) {
    throw ParameterError(source_of(error.what(), configs, settings) + error.what());
  }
  for (const std::string& line : unread) {
    warn(std::string(source_of(line, configs, settings)).append("parameter ").append(line));
  }
  return options;
}

}  // namespace kinect_ekf_slam
