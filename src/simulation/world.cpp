#include "kinect_ekf_slam/simulation/world.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/world_section.h"

namespace kinect_ekf_slam {
namespace {

using world_file::Bounds;
using world_file::kLargestRoom;
using world_file::Section;

constexpr int kLargestCount = 1000000;

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

void read_gps(Section gps, GpsOptions* o) {
  gps.number("rate", 0.0, 1000.0, &o->rate);
  gps.number("noise", 0.001, 1000.0, &o->noise);
  gps.number("drift", 0.0, 1000.0, &o->drift);
  gps.number("drift_time", 0.1, 1e5, &o->drift_time);
  gps.number("outlier_rate", 0.0, 1.0, &o->outlier_rate);
  gps.number("outlier_size", 0.0, 1e5, &o->outlier_size);
  gps.number("delay", 0.0, 60.0, &o->delay);
  if (gps.has("base_from_antenna")) o->antenna_in_base = gps.mounting("base_from_antenna").translation();
  gps.refuse_unknown();
}

void read_beacons(Section beacons, const Bounds& bounds, BeaconOptions* o) {
  beacons.number("rate", 0.0, 1000.0, &o->rate);
  beacons.number("noise", 0.001, 100.0, &o->noise);
  beacons.number("max_range", 0.0, 1e5, &o->max_range);
  beacons.number("outlier_rate", 0.0, 1.0, &o->outlier_rate);
  beacons.number("outlier_size", 0.0, 1e5, &o->outlier_size);
  if (beacons.has("base_from_receiver")) {
    o->receiver_in_base = beacons.mounting("base_from_receiver").translation();
  }
  if (beacons.has("places")) {
    std::set<int> ids;
    for (Section& item : beacons.list("places", "a list of {id, x, y, z}")) {
      int id = 0;
      Eigen::Vector3d place = Eigen::Vector3d::Zero();
      item.required_integer("id", 0, kLargestCount, &id);
      item.required_number("x", bounds.low.x(), bounds.high.x(), &place.x());
      item.required_number("y", bounds.low.y(), bounds.high.y(), &place.y());
      item.required_number("z", bounds.low.z(), bounds.high.z(), &place.z());
      item.refuse_unknown();
      if (!ids.insert(id).second) {
        item.fail(item.name("id"), std::to_string(id), "a number that no other beacon has");
      }
      o->places_in_world[id] = place;
    }
  }
  beacons.refuse_unknown();
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
  read_gps(root.section("gps"), &world.gps);
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(10.0 * kLargestRoom);  // outside the room as well
  read_beacons(root.section("beacons"), {true, -far, far}, &world.beacons);
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
