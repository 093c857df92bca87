#include "kinect_ekf_slam/mapping/yaml_keys.h"

#include <set>

#include "kinect_ekf_slam/core/one_line.h"

namespace kinect_ekf_slam {
namespace {

constexpr std::size_t kLongestShown = 60;
constexpr int kMostLevels = 8;
constexpr int kMostNodes = 100000;

std::string at(const YAML::Node& node, const std::string& what) {
  return "line " + std::to_string(node.Mark().line + 1) + ": " + what;
}

std::string fault_within(const YAML::Node& tree, int levels, int* nodes) {
  if (++*nodes > kMostNodes) return at(tree, "more than " + std::to_string(kMostNodes) + " entries");
  if (!tree.IsMap() && !tree.IsSequence()) return "";
  if (levels == 0) return at(tree, "nested too deeply");
  if (tree.IsMap()) {
    if (std::string fault = repeated_key(tree); !fault.empty()) return fault;
  }
  for (const auto& entry : tree) {
    std::string fault = fault_within(tree.IsMap() ? entry.second : entry, levels - 1, nodes);
    if (!fault.empty()) return fault;
  }
  return "";
}

}  // namespace

std::string repeated_key(const YAML::Node& map) {
  std::set<std::string> keys;
  for (const auto& entry : map) {
    const YAML::Node& key = entry.first;
    if (!key.IsScalar()) return at(key, "a key is not plain text");
    if (!keys.insert(key.Scalar()).second)
      return at(key, "key '" + one_line(key.Scalar(), kLongestShown) + "' is given twice");
  }
  return "";
}

std::string repeated_key_within(const YAML::Node& tree) {
  int nodes = 0;
  return fault_within(tree, kMostLevels, &nodes);
}

}  // namespace kinect_ekf_slam
