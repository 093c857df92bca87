#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/se3.h"
#include "kinect_ekf_slam/simulation/world.h"

/// How world files are read: for world.cpp alone.
namespace kinect_ekf_slam::world_file {

constexpr double kLargestRoom = 1000.0;  // m

inline std::string text_of(const YAML::Node& node) {
  YAML::Emitter text;
  text.SetSeqFormat(YAML::Flow);
  text.SetMapFormat(YAML::Flow);
  text << node;
  return text.c_str();
}

inline std::string text_of(int value) { return std::to_string(value); }

inline std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Between what a point may lie. On the floor it has two coordinates, and its height is zero.
struct Bounds {
  bool spatial;
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  std::size_t axes() const { return spatial ? 3 : 2; }
  std::string form() const { return spatial ? "[x, y, z] in m" : "[x, y] in m"; }
};

/// One map of the file. Remembers what was asked for, so that what nobody asked for can be refused.
class Section {
 public:
  Section(const YAML::Node& node, std::string file, std::string path)
      : node_(node), file_(std::move(file)), path_(std::move(path)) {
    if (node_.IsDefined() && !node_.IsNull() && !node_.IsMap())
      fail(path_, node_, "a map of keys and values");
  }

  Section section(const std::string& key) {
    const YAML::Node node = find(key);
    return {node, file_, name(key)};
  }

  bool has(const std::string& key) { return find(key).IsDefined(); }

  std::vector<Section> list(const std::string& key, const std::string& allowed) {
    const YAML::Node node = required(key, allowed);
    if (!node.IsSequence()) fail(name(key), node, allowed);
    std::vector<Section> sections;
    for (std::size_t i = 0; i < node.size(); ++i) {
      const std::string item = name(key) + "[" + std::to_string(i) + "]";
      if (!node[i].IsMap()) fail(item, node[i], "a map of keys and values");
      sections.emplace_back(node[i], file_, item);
    }
    return sections;
  }

  /// Keeps the value it has when the key is not there.
  void number(const std::string& key, double low, double high, double* value) {
    const YAML::Node node = find(key);
    if (node) *value = in_range(name(key), node, low, high);
  }
  void required_number(const std::string& key, double low, double high, double* value) {
    *value = in_range(name(key), required(key, "a number " + range(low, high)), low, high);
  }
  void integer(const std::string& key, int low, int high, int* value) {
    const YAML::Node node = find(key);
    if (node) *value = whole(key, node, low, high);
  }
  void required_integer(const std::string& key, int low, int high, int* value) {
    *value = whole(key, required(key, "a whole number " + range(low, high)), low, high);
  }
  void boolean(const std::string& key, bool* value) {
    const YAML::Node node = find(key);
    if (node && !YAML::convert<bool>::decode(node, *value)) fail(name(key), node, "true or false");
  }
  void required_text(const std::string& key, std::string* value) {
    const YAML::Node node = required(key, "text, not empty");
    if (!node.IsScalar() || node.Scalar().empty()) fail(name(key), node, "text, not empty");
    *value = node.Scalar();
  }
  /// The first of the names when the key is not there.
  std::string choice(const std::string& key, const std::vector<std::string>& names) {
    const YAML::Node node = find(key);
    if (!node) return names.front();
    std::string allowed;
    for (const std::string& candidate : names) {
      if (node.IsScalar() && node.Scalar() == candidate) return candidate;
      allowed += (allowed.empty() ? "" : ", ") + candidate;
    }
    fail(name(key), node, allowed);
  }
  Eigen::Vector3d required_point(const std::string& key, const Bounds& bounds) {
    return point(name(key), required(key, bounds.form()), bounds);
  }
  std::vector<Eigen::Vector3d> points(const std::string& key, const Bounds& bounds) {
    std::vector<Eigen::Vector3d> found;
    const YAML::Node node = find(key);
    if (!node) return found;
    if (!node.IsSequence()) fail(name(key), node, "a list of " + bounds.form());
    for (std::size_t i = 0; i < node.size(); ++i) {
      found.push_back(point(name(key) + "[" + std::to_string(i) + "]", node[i], bounds));
    }
    return found;
  }
  /// {xyz: [m], rpy_deg: [deg, fixed axes]}
  Eigen::Isometry3d mounting(const std::string& key) {
    Section mount = section(key);
    const Eigen::Vector3d xyz = mount.triple("xyz", kLargestRoom);
    const Eigen::Vector3d rpy_deg = mount.triple("rpy_deg", 360.0);
    mount.refuse_unknown();
    Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
    transform.translation() = xyz;
    transform.linear() =
        rotation_from_rpy({radians(rpy_deg.x()), radians(rpy_deg.y()), radians(rpy_deg.z())});
    return transform;
  }

  void refuse_unknown() const {
    if (!node_.IsDefined() || !node_.IsMap()) return;
    for (const auto& entry : node_) {
      const std::string key = text_of(entry.first);
      if (known_.count(key) > 0) continue;
      std::string allowed;
      for (const std::string& candidate : known_) allowed += (allowed.empty() ? "" : ", ") + candidate;
      throw WorldFileError(file_ + ": " + name(key) + ": is not known, allowed: " + allowed);
    }
  }

  [[noreturn]] void fail(const std::string& key, const YAML::Node& node, const std::string& allowed) const {
    fail(key, text_of(node), allowed);
  }
  [[noreturn]] void fail(const std::string& key, const std::string& given, const std::string& allowed) const {
    throw WorldFileError(file_ + ": " + (key.empty() ? "" : key + ": ") + "'" + given +
                         "' given, allowed: " + allowed);
  }

  std::string name(const std::string& key) const { return path_.empty() ? key : path_ + "/" + key; }

 private:
  YAML::Node find(const std::string& key) {
    known_.insert(key);
    if (!node_.IsDefined() || !node_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    return static_cast<const YAML::Node&>(node_)[key];
  }

  YAML::Node required(const std::string& key, const std::string& allowed) {
    const YAML::Node node = find(key);
    if (!node) throw WorldFileError(file_ + ": " + name(key) + ": is missing, allowed: " + allowed);
    return node;
  }

  template <class Value>
  static std::string range(Value low, Value high) {
    return "from " + text_of(low) + " to " + text_of(high);
  }

  double in_range(const std::string& key, const YAML::Node& node, double low, double high) const {
    double value = 0.0;
    const bool is_number = node.IsScalar() && YAML::convert<double>::decode(node, value);
    if (!is_number || !(value >= low && value <= high)) fail(key, node, "a number " + range(low, high));
    return value;
  }

  int whole(const std::string& key, const YAML::Node& node, int low, int high) const {
    int value = 0;
    const bool is_whole = node.IsScalar() && YAML::convert<int>::decode(node, value);
    if (!is_whole || value < low || value > high) fail(name(key), node, "a whole number " + range(low, high));
    return value;
  }

  Eigen::Vector3d point(const std::string& key, const YAML::Node& node, const Bounds& bounds) const {
    if (!node.IsSequence() || node.size() != bounds.axes()) fail(key, node, bounds.form());
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < bounds.axes(); ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      const std::string entry = key + "[" + std::to_string(i) + "]";
      point(axis) = in_range(entry, node[i], bounds.low(axis), bounds.high(axis));
    }
    return point;
  }

  Eigen::Vector3d triple(const std::string& key, double limit) {
    const YAML::Node node = required(key, "three numbers");
    if (!node.IsSequence() || node.size() != 3) fail(name(key), node, "three numbers");
    Eigen::Vector3d values;
    for (int i = 0; i < 3; ++i) {
      values(i) = in_range(name(key) + "[" + std::to_string(i) + "]", node[i], -limit, limit);
    }
    return values;
  }

  YAML::Node node_;
  std::string file_;
  std::string path_;
  std::set<std::string> known_;
};

}  // namespace kinect_ekf_slam::world_file
