#include "kinect_ekf_slam/ros/markers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/ros/conversions.h"

namespace kinect_ekf_slam {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kLandmarkHeight = 0.30;  // m
constexpr double kDefaultRadius = 0.05;   // m, of a landmark that told none
constexpr double kFlat = 0.01;            // m, height of what lies on the floor
constexpr double kSmallest = 0.004;       // m: an ellipse stays visible
constexpr double kLineHeight = 0.1;       // m, of a line from the robot to a cylinder
constexpr double kThin = 0.015;           // m, width of a line
constexpr float kFaint = 0.35F;           // alpha of a landmark that is not confirmed
constexpr double kWedgeLength = 0.6;      // m
constexpr double kWidestWedge = 0.5 * kPi;

std_msgs::ColorRGBA color(double r, double g, double b, double a) {
  std_msgs::ColorRGBA color;
  color.r = static_cast<float>(r);
  color.g = static_cast<float>(g);
  color.b = static_cast<float>(b);
  color.a = static_cast<float>(a);
  return color;
}

std_msgs::ColorRGBA hue(double turn) {
  const auto channel = [&](double shift) {
    return std::clamp(std::abs(std::fmod(6.0 * (turn + shift), 6.0) - 3.0) - 1.0, 0.0, 1.0);
  };
  return color(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0), 1.0);
}

geometry_msgs::Quaternion heading_quaternion(double heading) {
  return to_quaternion(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix());
}

void shape_as_ellipse(const Ellipse& shape, Marker* marker) {
  marker->scale.x = std::max(2.0 * shape.major, kSmallest);
  marker->scale.y = std::max(2.0 * shape.minor, kSmallest);
  marker->scale.z = kFlat;
  marker->pose.orientation = heading_quaternion(shape.heading);
}

void shape_as_ellipsoid(const Ellipsoid& shape, Marker* marker) {
  const Eigen::Vector3d diameters = (2.0 * shape.half_axes).cwiseMax(kSmallest);
  marker->scale = to_vector(diameters);
  marker->pose.orientation = to_quaternion(shape.axes);
}

/// The eigenvalues of a covariance and their vectors, ascending.
template <int kDim>
Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kDim, kDim>> axes_of(
    const Eigen::Matrix<double, kDim, kDim>& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kDim, kDim>> solver(covariance);
  const double largest = solver.eigenvalues()(kDim - 1);
  if (!covariance.allFinite() || solver.eigenvalues()(0) < -1e-9 * std::max(1.0, largest) ||
      !(largest > 0.0)) {
    throw std::invalid_argument("not a covariance");
  }
  return solver;
}

}  // namespace

Ellipse ellipse(const Eigen::Matrix2d& covariance, double sigmas) {
  const auto solver = axes_of<2>(covariance);
  const Eigen::Vector2d& values = solver.eigenvalues();
  const Eigen::Vector2d axis = solver.eigenvectors().col(1);
  return {sigmas * std::sqrt(values(1)), sigmas * std::sqrt(std::max(values(0), 0.0)),
          std::atan2(axis.y(), axis.x())};
}

Ellipsoid ellipsoid(const Eigen::Matrix3d& covariance, double sigmas) {
  const auto solver = axes_of<3>(covariance);
  Ellipsoid shape{sigmas * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt(), solver.eigenvectors()};
  if (shape.axes.determinant() < 0.0) shape.axes.col(0) *= -1.0;  // mirrored: no rotation
  return shape;
}

std_msgs::ColorRGBA label_color(const std::string& label) {
  static const std::map<std::string, std_msgs::ColorRGBA> kNamed = {
      {"red", color(0.85, 0.15, 0.12, 1)},   {"green", color(0.15, 0.65, 0.2, 1)},
      {"blue", color(0.12, 0.35, 0.85, 1)},  {"yellow", color(0.95, 0.8, 0.1, 1)},
      {"orange", color(0.95, 0.5, 0.1, 1)},  {"purple", color(0.55, 0.2, 0.7, 1)},
      {"cyan", color(0.1, 0.75, 0.8, 1)},    {"magenta", color(0.85, 0.2, 0.7, 1)},
      {"white", color(0.95, 0.95, 0.95, 1)}, {"black", color(0.1, 0.1, 0.1, 1)},
      {"", color(0.6, 0.6, 0.6, 1)}};
  const auto named = kNamed.find(label);
  if (named != kNamed.end()) return named->second;
  return hue(static_cast<double>(std::hash<std::string>{}(label) % 360) / 360.0);
}

Marker MarkerPainter::marker(const std::string& space, int id, int type) const {
  Marker marker;
  marker.header.frame_id = frame_id_;
  marker.header.stamp = stamp_;
  marker.ns = space;
  marker.id = id;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  return marker;
}

MarkerArray MarkerPainter::paint(const MarkerScene& scene) {
  stamp_ = to_ros(scene.pose.stamp);
  MarkerArray array;
  paint_landmarks(scene.map, &array);
  paint_beacons(scene, &array);
  paint_robot(scene, &array);
  paint_associations(scene, &array);
  paint_path("path", scene.path, 2.0 * kThin, color(0.3, 0.65, 1.0, 1.0), &array);
  paint_path("dead_reckoning", scene.dead_reckoned_path, kThin, color(0.9, 0.55, 0.15, 0.7), &array);
  return array;
}

MarkerArray MarkerPainter::paint_global(const GlobalMap3d& map) {
  constexpr double kGoldenSection = 0.618;  // neighbours differ, however many there are
  stamp_ = ros::Time();                     // the frame does not move: wherever it is now
  MarkerArray array = clear();
  paint_landmarks(map.landmarks, &array);
  Marker positions = marker("positions", 0, Marker::POINTS);
  positions.scale.x = positions.scale.y = 2.0 * kThin;
  positions.color = color(0.6, 0.6, 0.6, 1.0);
  for (const auto& position : map.positions) positions.points.push_back(to_point(position.antenna));
  if (!positions.points.empty()) array.markers.push_back(positions);
  for (std::size_t i = 0; i < map.segments.size(); ++i) {
    const GlobalMap3d::Segment& segment = map.segments[i];
    const auto id = static_cast<int>(i);
    Marker path = marker("segments", id, Marker::LINE_STRIP);
    path.scale.x = 2.0 * kThin;
    path.color = hue(std::fmod(kGoldenSection * id, 1.0));
    for (const Pose3d& pose : segment.path) path.points.push_back(to_point(pose.map_from_base.translation()));
    if (path.points.size() > 1) array.markers.push_back(path);
    Marker left_out = marker("left_out", id, Marker::LINE_LIST);
    left_out.scale.x = kThin;
    left_out.color = color(0.9, 0.2, 0.2, 0.8);
    for (const auto& contradiction : segment.left_out) {
      left_out.points.push_back(to_point(contradiction.by_path));
      left_out.points.push_back(to_point(contradiction.by_position));
    }
    if (!left_out.points.empty()) array.markers.push_back(left_out);
  }
  return array;
}

MarkerArray MarkerPainter::clear() {
  shown_.clear();
  MarkerArray array;
  array.markers.push_back(marker("", 0, Marker::CUBE));
  array.markers.back().action = Marker::DELETEALL;
  return array;
}

/// Where something is with the probability of the sigmas; nothing that pretends it when the covariance is
/// none.
Marker MarkerPainter::spread(const std::string& space, int id, const Eigen::Vector3d& position_in_map,
                             const Eigen::Matrix3d& covariance) const {
  Marker spread = marker(space, id, is_planar() ? Marker::CYLINDER : Marker::SPHERE);
  spread.pose.position = to_point(position_in_map);
  try {
    if (is_planar()) {
      shape_as_ellipse(ellipse(covariance.topLeftCorner<2, 2>(), sigmas_), &spread);
    } else {
      shape_as_ellipsoid(ellipsoid(covariance, sigmas_), &spread);
    }
  } catch (const std::invalid_argument&) {
    spread.action = Marker::DELETE;
  }
  return spread;
}

Marker MarkerPainter::body_of(const Landmark3d& landmark) const {
  const double radius = landmark.radius > 0.0 ? landmark.radius : kDefaultRadius;
  Marker body = marker("landmarks", landmark.id, is_planar() ? Marker::CYLINDER : Marker::SPHERE);
  body.pose.position = to_point(landmark.position_in_map);
  body.scale.x = body.scale.y = body.scale.z = 2.0 * radius;
  if (is_planar()) {
    body.pose.position.z += 0.5 * kLandmarkHeight;
    body.scale.z = kLandmarkHeight;
  }
  body.color = label_color(landmark.label);
  if (!landmark.confirmed) body.color.a = kFaint;
  return body;
}

void MarkerPainter::paint_landmarks(const std::vector<Landmark3d>& map, MarkerArray* array) {
  std::set<int> gone;
  gone.swap(shown_);
  for (const Landmark3d& landmark : map) {
    gone.erase(landmark.id);
    shown_.insert(landmark.id);
    array->markers.push_back(body_of(landmark));
    const auto shade = array->markers.back().color;
    const double top = is_planar() ? kLandmarkHeight : 0.5 * array->markers.back().scale.z;

    Marker name = marker("labels", landmark.id, Marker::TEXT_VIEW_FACING);
    name.pose.position = to_point(landmark.position_in_map);
    name.pose.position.z += top + 0.12;
    name.scale.z = 0.16;
    name.color = color(1.0, 1.0, 1.0, shade.a);
    name.text = std::to_string(landmark.id) + (landmark.label.empty() ? "" : " " + landmark.label);
    if (!landmark.confirmed) name.text += "?";
    name.text += "\n\n";  // lifts it above the landmark, wherever one looks from
    array->markers.push_back(name);

    array->markers.push_back(
        spread("covariance", landmark.id, landmark.position_in_map, landmark.covariance));
    array->markers.back().color = shade;
    array->markers.back().color.a *= 0.4F;
  }
  for (const int id : gone) {
    for (const char* space : {"landmarks", "labels", "covariance"}) {
      array->markers.push_back(marker(space, id, Marker::CYLINDER));
      array->markers.back().action = Marker::DELETE;
    }
  }
}

void MarkerPainter::paint_beacons(const MarkerScene& scene, MarkerArray* array) const {
  constexpr double kEdge = 0.15;  // m
  const std_msgs::ColorRGBA shade = color(0.2, 0.8, 0.7, 1.0);
  for (const Landmark3d& beacon : scene.beacons) {
    Marker body = marker("beacons", beacon.id, Marker::CUBE);
    body.pose.position = to_point(beacon.position_in_map);
    body.scale.x = body.scale.y = body.scale.z = kEdge;
    body.color = shade;
    array->markers.push_back(body);
    array->markers.push_back(
        spread("beacon_covariance", beacon.id, beacon.position_in_map, beacon.covariance));
    array->markers.back().color = shade;
    array->markers.back().color.a *= 0.4F;
  }
}

void MarkerPainter::paint_robot(const MarkerScene& scene, MarkerArray* array) const {
  Marker position = spread("robot_position", 0, scene.pose.map_from_base.translation(),
                           scene.pose.covariance.topLeftCorner<3, 3>());
  if (is_planar()) position.pose.position.z += 4.0 * kFlat;
  position.color = color(0.65, 0.2, 0.9, 0.5);
  array->markers.push_back(position);

  Marker wedge = marker("robot_heading", 0, Marker::TRIANGLE_LIST);
  wedge.pose = to_pose(scene.pose.map_from_base);
  wedge.pose.position.z += 2.0 * kFlat;
  wedge.scale.x = wedge.scale.y = wedge.scale.z = 1.0;
  wedge.color = color(0.95, 0.85, 0.1, 0.7);
  const Eigen::Vector3d up = scene.pose.map_from_base.linear().col(2);  // the base's, about which it heads
  const double variance = up.dot(scene.pose.covariance.bottomRightCorner<3, 3>() * up);
  const double half = std::clamp(sigmas_ * std::sqrt(std::max(variance, 0.0)), radians(0.5), kWidestWedge);
  constexpr int kSlices = 12;
  const auto edge = [&](int slice) {
    const double angle = half * (2.0 * slice / kSlices - 1.0);
    return to_point(kWedgeLength * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0));
  };
  for (int slice = 0; slice < kSlices; ++slice) {
    for (const auto& corner : {to_point(Eigen::Vector3d::Zero()), edge(slice), edge(slice + 1)})
      wedge.points.push_back(corner);
  }
  if (!std::isfinite(variance)) wedge.action = Marker::DELETE;
  array->markers.push_back(wedge);

  Marker body = marker("robot", 0, Marker::TRIANGLE_LIST);
  body.pose = to_pose(scene.pose.map_from_base);
  body.pose.position.z += 3.0 * kFlat;
  body.scale.x = body.scale.y = body.scale.z = 1.0;
  body.color = color(0.85, 0.87, 0.9, 1.0);
  const Eigen::Vector3d nose(0.22, 0.0, 0.0);
  const Eigen::Vector3d notch(-0.07, 0.0, 0.0);
  const Eigen::Vector3d left(-0.14, 0.13, 0.0);
  const Eigen::Vector3d right(-0.14, -0.13, 0.0);
  for (const Eigen::Vector3d& corner : {nose, left, notch, nose, notch, right})
    body.points.push_back(to_point(corner));
  array->markers.push_back(body);
}

void MarkerPainter::paint_associations(const MarkerScene& scene, MarkerArray* array) const {
  Marker lines = marker("associations", 0, Marker::LINE_LIST);
  lines.scale.x = kThin;
  lines.color.a = 1.0F;
  for (const DetectionOutcome& outcome : scene.outcomes) {
    if (!outcome.position_in_map.allFinite()) continue;
    Eigen::Vector3d target = outcome.position_in_map;
    if (is_accepted(outcome.verdict)) {
      const auto landmark =
          std::find_if(scene.map.begin(), scene.map.end(),
                       [&](const Landmark3d& candidate) { return candidate.id == outcome.landmark_id; });
      if (landmark != scene.map.end()) target = landmark->position_in_map;
    }
    const auto shade = outcome.verdict == Verdict::kMatched   ? color(0.2, 0.9, 0.3, 1.0)
                       : outcome.verdict == Verdict::kCreated ? color(0.2, 0.7, 1.0, 1.0)
                                                              : color(0.9, 0.2, 0.2, 0.8);
    const Eigen::Vector3d lift(0.0, 0.0, is_planar() ? kLineHeight : 0.0);
    for (const Eigen::Vector3d& end : {Eigen::Vector3d(scene.pose.map_from_base.translation()), target}) {
      lines.points.push_back(to_point(end + lift));
      lines.colors.push_back(shade);
    }
  }
  if (lines.points.empty()) lines.action = Marker::DELETE;
  array->markers.push_back(lines);
}

void MarkerPainter::paint_path(const std::string& space, const std::vector<geometry_msgs::Point>& points,
                               double width, const std_msgs::ColorRGBA& shade, MarkerArray* array) const {
  Marker line = marker(space, 0, Marker::LINE_STRIP);
  line.pose.position.z = width;  // the wider one on top
  line.scale.x = width;
  line.color = shade;
  line.points = points;
  if (points.size() < 2) line.action = Marker::DELETE;
  array->markers.push_back(line);
}

}  // namespace kinect_ekf_slam
