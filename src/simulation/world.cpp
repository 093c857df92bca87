#include "kinect_ekf_slam/simulation/world.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kLargestRoom = 1000.0;  // m
constexpr int kLargestCount = 1000000;

std::string text_of(const YAML::Node& node) {
  YAML::Emitter text;
  text.SetSeqFormat(YAML::Flow);
  text.SetMapFormat(YAML::Flow);
  text << node;
  return text.c_str();
}

std::string text_of(int value) { return std::to_string(value); }

std::string text_of(double value) {
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

void read_landmarks(Section& root, bool spatial, World* world) {
  constexpr double kTallest = 10.0;  // m
  std::set<int> ids;
  for (Section& item : root.list("landmarks", "a list of {id, label, x, y, z, radius}")) {
    WorldLandmark landmark;
    Eigen::Vector3d& position = landmark.position_in_world;
    item.required_integer("id", 0, kLargestCount, &landmark.id);
    item.required_text("label", &landmark.label);
    item.required_number("x", 0.0, world->room_size.x(), &position.x());
    item.required_number("y", 0.0, world->room_size.y(), &position.y());
    item.required_number("z", 0.0, spatial ? world->room_size.z() : kTallest, &position.z());
    item.required_number("radius", 0.001, 10.0, &landmark.radius);
    item.refuse_unknown();
    if (!ids.insert(landmark.id).second) {
      item.fail(item.name("id"), std::to_string(landmark.id), "a number that no other landmark has");
    }
    world->landmarks.push_back(landmark);
  }
}

void read_panels(Section& root, const Bounds& bounds, World* world) {
  if (!root.has("panels")) return;
  for (Section& item : root.list("panels", "a list of {x, y, z, facing_deg, size, print, id}")) {
    WorldPanel panel;
    Eigen::Vector3d& center = panel.center_in_world;
    item.required_number("x", 0.0, bounds.high.x(), &center.x());
    item.required_number("y", 0.0, bounds.high.y(), &center.y());
    item.required_number("z", 0.0, bounds.high.z(), &center.z());
    item.required_number("facing_deg", -360.0, 360.0, &panel.facing_deg);
    item.required_number("size", 0.01, kLargestRoom, &panel.size);
    const bool is_fiducial = item.choice("print", {"blotches", "fiducial"}) == "fiducial";
    panel.print = is_fiducial ? WorldPanel::Print::kFiducial : WorldPanel::Print::kBlotches;
    constexpr int kMostFiducials = 50;  // of the dictionary
    item.integer("id", 0, is_fiducial ? kMostFiducials - 1 : kLargestCount, &panel.id);
    item.refuse_unknown();
    world->panels.push_back(panel);
  }
}

void read_room(Section& root, bool spatial, World* world) {
  Section room = root.section("room");
  world->room_size = room.required_point(
      "size", {spatial, Eigen::Vector3d::Constant(0.5), Eigen::Vector3d::Constant(kLargestRoom)});
  if (spatial) {
    world->wall_height = world->room_size.z();
  } else {
    room.number("wall_height", 0.0, kLargestRoom, &world->wall_height);
  }
  world->has_blotches = room.choice("surface", {"plain", "blotches"}) == "blotches";
  room.refuse_unknown();
  Eigen::Vector3d high = world->room_size;
  high.z() = world->wall_height;
  read_panels(root, {true, Eigen::Vector3d::Zero(), high}, world);
}

RobotPose read_start(Section start, const Bounds& bounds) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy_deg = Eigen::Vector3d::Zero();
  start.required_number("x", bounds.low.x(), bounds.high.x(), &position.x());
  start.required_number("y", bounds.low.y(), bounds.high.y(), &position.y());
  if (bounds.spatial) {
    start.required_number("z", bounds.low.z(), bounds.high.z(), &position.z());
    start.number("roll_deg", -360.0, 360.0, &rpy_deg.x());
    start.number("pitch_deg", -360.0, 360.0, &rpy_deg.y());
  }
  start.required_number("yaw_deg", -360.0, 360.0, &rpy_deg.z());
  start.refuse_unknown();
  if (!bounds.spatial) return Se2(position.x(), position.y(), radians(rpy_deg.z()));
  const Eigen::Matrix3d rotation =
      rotation_from_rpy({radians(rpy_deg.x()), radians(rpy_deg.y()), radians(rpy_deg.z())});
  return Se3(position, Eigen::Quaterniond(rotation));
}

void read_drive(Section drive, bool spatial, const Eigen::Vector3d& room_size, DriveOptions* o) {
  drive.number("robot_radius", 0.0, 0.4 * room_size.head(spatial ? 3 : 2).minCoeff(), &o->robot_radius);
  const Eigen::Vector3d low = Eigen::Vector3d::Constant(o->robot_radius);
  const Bounds free{spatial, low, room_size - low};
  o->world_from_start = read_start(drive.section("start"), free);
  o->waypoints_in_world = drive.points("waypoints", free);
  drive.integer("loops", 1, kLargestCount, &o->loops);
  drive.number("standing_time", 0.0, 3600.0, &o->standing_time);
  drive.number("max_speed", 0.001, 10.0, &o->max_speed);
  drive.number("max_turn_rate", 0.001, 20.0, &o->max_turn_rate);
  drive.number("max_acceleration", 0.001, 100.0, &o->max_acceleration);
  drive.number("max_turn_acceleration", 0.001, 1000.0, &o->max_turn_acceleration);
  drive.refuse_unknown();
}

void read_wheels(Section wheels, WheelOptions* o) {
  wheels.number("rate", 1.0, 1000.0, &o->rate);
  wheels.number("separation", 0.01, 10.0, &o->separation);
  wheels.number("scale_sigma", 0.0, 0.5, &o->scale_sigma);
  wheels.number("noise", 0.0, 1.0, &o->noise);
  wheels.number("slips_per_minute", 0.0, 600.0, &o->slips_per_minute);
  wheels.number("slip_share", 0.0, 10.0, &o->slip_share);
  wheels.number("slip_time", 0.0, 60.0, &o->slip_time);
  wheels.refuse_unknown();
}

void read_gyro(Section gyro, GyroOptions* o) {
  gyro.number("rate", 1.0, 1000.0, &o->rate);
  gyro.number("noise", 0.0, 10.0, &o->noise);
  gyro.number("scale_sigma", 0.0, 0.5, &o->scale_sigma);
  gyro.number("bias_sigma", 0.0, 10.0, &o->bias_sigma);
  gyro.number("bias_walk", 0.0, 10.0, &o->bias_walk);
  o->base_from_imu = gyro.mounting("base_from_imu");
  gyro.refuse_unknown();
}

void read_sensor(Section sensor, KinectOptions* o) {
  sensor.number("rate", 0.1, 1000.0, &o->rate);
  sensor.number("field_of_view_deg", 1.0, 179.0, &o->field_of_view_deg);
  sensor.number("vertical_field_of_view_deg", 1.0, 179.0, &o->vertical_field_of_view_deg);
  sensor.number("min_depth", 0.0, 100.0, &o->min_depth);
  sensor.number("max_depth", o->min_depth, 100.0, &o->max_depth);
  sensor.number("noise_scale", 0.0, 100.0, &o->noise_scale);
  sensor.number("radius_noise", 0.0, 1.0, &o->radius_noise);
  sensor.number("miss_rate", 0.0, 1.0, &o->miss_rate);
  sensor.number("false_per_minute", 0.0, 60.0 * o->rate, &o->false_per_minute);
  sensor.number("gross_error_rate", 0.0, 1.0, &o->gross_error_rate);
  sensor.number("gross_error_size", 0.0, 100.0, &o->gross_error_size);
  sensor.number("wrong_label_rate", 0.0, 1.0, &o->wrong_label_rate);
  sensor.boolean("reports_covariance", &o->reports_covariance);
  sensor.boolean("reports_identity", &o->reports_identity);
  o->base_from_optical = sensor.mounting("base_from_optical");
  sensor.refuse_unknown();
}

void read_camera(Section camera, PictureOptions* o) {
  constexpr int kLargestPicture = 4096;  // pixels
  camera.number("rate", 0.0, 1000.0, &o->rate);
  camera.integer("width", 16, kLargestPicture, &o->camera.width);
  camera.integer("height", 16, kLargestPicture, &o->camera.height);
  camera.number("focal_length", 1.0, 1e5, &o->camera.focal_length);
  camera.boolean("errors", &o->has_errors);
  camera.refuse_unknown();
}

World read(const YAML::Node& yaml, const std::string& file) {
  Section root(yaml, file, "");
  World world;
  const bool spatial = root.choice("space", {Planar::kName, Spatial::kName}) == Spatial::kName;
  read_room(root, spatial, &world);
  read_landmarks(root, spatial, &world);
  read_drive(root.section("drive"), spatial, world.room_size, &world.drive);
  read_wheels(root.section("wheels"), &world.wheels);
  read_gyro(root.section("gyro"), &world.gyro);
  read_sensor(root.section("sensor"), &world.sensor);
  read_camera(root.section("camera"), &world.pictures);
  root.refuse_unknown();
  return world;
}

}  // namespace

World parse_world(const std::string& yaml, const std::string& name) {
  try {
    return read(YAML::Load(yaml), name);
  } catch (const YAML::Exception& error) {
    throw WorldFileError(name + ": not YAML: " + error.what());
  }
}

World read_world(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!(text << file.rdbuf())) throw WorldFileError(path + ": cannot be read");
  return parse_world(text.str(), path);
}

}  // namespace kinect_ekf_slam
