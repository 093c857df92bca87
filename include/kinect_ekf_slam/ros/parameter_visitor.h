#pragma once

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/ros/parameters.h"
#include "kinect_ekf_slam/ros/spelling.h"

namespace kinect_ekf_slam {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Value>
using Choices = std::vector<std::pair<std::string, Value>>;

inline std::string text_of(const YAML::Node& node) {
  YAML::Emitter text;
  text.SetSeqFormat(YAML::Flow);
  text.SetMapFormat(YAML::Flow);
  text << node;
  return text.c_str();
}

inline std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

inline std::string text_of(int value) { return std::to_string(value); }

/// Goes through all parameters once: reads them, or only lists them when there is no YAML.
class ParameterVisitor {
 public:
  explicit ParameterVisitor(const YAML::Node* yaml) : yaml_(yaml) {}

  void number(const std::string& key, double* value, double low, double high, const std::string& unit,
              const std::string& meaning) {
    const std::string allowed = range(low, high);
    note({key, text_of(*value), unit, allowed, meaning});
    if (const YAML::Node node = find(key)) {
      *value = convert<double>(key, node, "a number " + allowed);
      if (!(*value >= low && *value <= high)) fail(key, node, "a number " + allowed);
    }
  }

  void integer(const std::string& key, int* value, int low, int high, const std::string& unit,
               const std::string& meaning) {
    const std::string allowed = range(low, high);
    note({key, text_of(*value), unit, allowed, meaning});
    if (const YAML::Node node = find(key)) {
      *value = convert<int>(key, node, "a whole number " + allowed);
      if (*value < low || *value > high) fail(key, node, "a whole number " + allowed);
    }
  }

  void boolean(const std::string& key, bool* value, const std::string& meaning) {
    note({key, *value ? "true" : "false", "", "true, false", meaning});
    if (const YAML::Node node = find(key)) *value = convert<bool>(key, node, "true or false");
  }

  void text(const std::string& key, std::string* value, bool may_be_empty, const std::string& meaning) {
    const std::string allowed = may_be_empty ? "text" : "text, not empty";
    note({key, *value, "", allowed, meaning});
    if (const YAML::Node node = find(key)) {
      *value = may_be_empty && node.IsNull() ? "" : convert<std::string>(key, node, allowed);
      if (!may_be_empty && value->empty()) fail(key, node, allowed);
    }
  }

  void frame(const std::string& key, std::string* value, const std::string& meaning) {
    require(key);
    text(key, value, false, meaning);
    if (!value->empty() && value->front() == '/') {
      throw ParameterError(key + ": '" + *value + "': a frame has no leading slash");
    }
  }

  template <class Value>
  void choice(const std::string& key, Value* value, const Choices<Value>& choices,
              const std::string& meaning) {
    std::string allowed;
    std::string present;
    for (const auto& [name, candidate] : choices) {
      allowed += (allowed.empty() ? "" : ", ") + name;
      if (candidate == *value) present = name;
    }
    note({key, present, "", allowed, meaning});
    const YAML::Node node = find(key);
    if (!node) return;
    const auto name = convert<std::string>(key, node, "one of " + allowed);
    for (const auto& [candidate_name, candidate] : choices) {
      if (candidate_name == name) {
        *value = candidate;
        return;
      }
    }
    fail(key, node, "one of " + allowed);
  }

  void transforms(const std::string& key, std::vector<StaticTransformOption>* value,
                  const std::string& meaning) {
    const std::string allowed = "a list of {parent, child, xyz: [m], rpy_deg: [deg]}";
    note({key, "[]", "m, deg", allowed, meaning});
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsSequence()) fail(key, node, allowed);
    for (const YAML::Node& item : node) {
      StaticTransformOption transform;
      try {
        transform.parent = item["parent"].as<std::string>();
        transform.child = item["child"].as<std::string>();
        transform.xyz = item["xyz"].as<std::vector<double>>();
        transform.rpy_deg = item["rpy_deg"].as<std::vector<double>>();
      } catch (const YAML::Exception&) {
        fail(key, item, allowed);
      }
      const bool has_frames = is_frame(transform.parent) && is_frame(transform.child);
      if (!has_frames || transform.parent == transform.child || !is_triple(transform.xyz) ||
          !is_triple(transform.rpy_deg)) {
        fail(key, item, allowed);  // tf would ignore it
      }
      value->push_back(std::move(transform));
    }
  }

  void beacons(const std::string& key, std::vector<Beacon>* value, const std::string& meaning) {
    const std::string allowed = "a list of {id, xyz: [m], sigma: m}, no id twice, sigma more than 0";
    note({key, "[]", "m", allowed, meaning});
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsSequence()) fail(key, node, allowed);
    std::set<int> ids;
    for (const YAML::Node& item : node) {
      Beacon beacon;
      std::vector<double> xyz;
      try {
        beacon.id = item["id"].as<int>();
        xyz = item["xyz"].as<std::vector<double>>();
        beacon.sigma = item["sigma"].as<double>();
      } catch (const YAML::Exception&) {
        fail(key, item, allowed);
      }
      constexpr int kLargestId = 1000000;
      const bool is_known = item.size() == 3 && is_triple(xyz) && beacon.sigma > 0.0 && beacon.sigma <= 1e3;
      if (beacon.id < 0 || beacon.id > kLargestId || !is_known || !ids.insert(beacon.id).second) {
        fail(key, item, allowed);
      }
      beacon.position_in_map = {xyz[0], xyz[1], xyz[2]};
      value->push_back(beacon);
    }
  }

  /// Pairs of times.
  void stretches(const std::string& key, std::vector<std::pair<double, double>>* value,
                 const std::string& meaning) {
    const std::string allowed = "a list of [from, to]";
    note({key, "[]", "s", allowed, meaning});
    const YAML::Node node = find(key);
    if (!node) return;
    for (const auto& stretch : convert<std::vector<std::vector<double>>>(key, node, allowed)) {
      if (stretch.size() != 2 || !(stretch[0] <= stretch[1])) fail(key, node, allowed);
      value->emplace_back(stretch[0], stretch[1]);
    }
  }

  void datum(const std::string& key, std::vector<double>* value, const std::string& meaning) {
    const std::string allowed = "first_fix, or [latitude deg, longitude deg, altitude m]";
    note({key, "first_fix", "deg, m", allowed, meaning});
    const YAML::Node node = find(key);
    if (!node || (node.IsScalar() && node.Scalar() == "first_fix")) return;
    *value = convert<std::vector<double>>(key, node, allowed);
    if (!is_triple(*value) || std::abs((*value)[0]) > 90.0 || std::abs((*value)[1]) > 360.0)
      fail(key, node, allowed);
  }

  void require(const std::string& key) {
    required_.insert(key);
    if (yaml_ != nullptr && !find(key)) {
      throw ParameterError(key + ": is missing; start from config/slam.yaml (slam.launch loads it)");
    }
  }

  /// A line for each key that nothing has read.
  std::vector<std::string> unread() const {
    std::vector<std::string> lines;
    if (yaml_ == nullptr || !yaml_->IsMap()) return lines;
    for (const auto& group : *yaml_) {
      const auto name = group.first.as<std::string>();
      if (!group.second.IsMap()) {
        if (known_.count(name) == 0 || name.find('/') != std::string::npos) lines.push_back(not_read(name));
        continue;
      }
      for (const auto& entry : group.second) {
        const std::string key = name + "/" + entry.first.as<std::string>();
        if (known_.count(key) == 0) lines.push_back(not_read(key));
      }
    }
    return lines;
  }

  std::vector<ParameterInfo> infos() const { return infos_; }

 private:
  static bool is_frame(const std::string& name) { return !name.empty() && name.front() != '/'; }
  static bool is_triple(const std::vector<double>& values) {
    return values.size() == 3 &&
           std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  }

  template <class Number>
  static std::string range(Number low, Number high) {
    if (high == kInfinity) return low == -kInfinity ? "of any size" : ">= " + text_of(low);
    return "from " + text_of(low) + " to " + text_of(high);
  }

  std::string not_read(const std::string& key) const {
    const std::string meant = similar_key(key, {known_.begin(), known_.end()});
    return key + " is not known and was not read" + (meant.empty() ? "" : "; did you mean " + meant + "?");
  }

  void note(ParameterInfo info) {
    known_.insert(info.key);
    info.required = required_.count(info.key) > 0;
    infos_.push_back(std::move(info));
  }

  YAML::Node find(const std::string& key) const {
    if (yaml_ == nullptr || !yaml_->IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    const auto slash = key.find('/');
    if (slash == std::string::npos) return (*yaml_)[key];
    const YAML::Node group = (*yaml_)[key.substr(0, slash)];
    if (!group || !group.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    return group[key.substr(slash + 1)];
  }

  template <class Value>
  static Value convert(const std::string& key, const YAML::Node& node, const std::string& allowed) {
    if (node.IsNull()) fail(key, node, allowed);  // yaml-cpp has a text for nothing: "null"
    try {
      return node.as<Value>();
    } catch (const YAML::Exception&) {
      fail(key, node, allowed);
    }
  }

  [[noreturn]] static void fail(const std::string& key, const YAML::Node& node, const std::string& allowed) {
    const bool is_empty = node.IsNull() || (node.IsScalar() && node.Scalar().empty());
    throw ParameterError(key + (is_empty ? ": is empty" : ": '" + text_of(node) + "' given") +
                         ", allowed: " + allowed);
  }

  const YAML::Node* yaml_;
  std::set<std::string> known_;
  std::set<std::string> required_;
  std::vector<ParameterInfo> infos_;
};

}  // namespace kinect_ekf_slam
