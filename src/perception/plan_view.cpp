#include "kinect_ekf_slam/perception/plan_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace kinect_ekf_slam {
namespace {

struct Reading {
  double distance;  ///< m, level, from the camera's foot
  double height;    ///< m
  double depth;     ///< m
};

/// Neighbours in distance, readings[first] to readings[last - 1]: what a surface that stands upright shows.
struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
  double lowest = 0.0;   ///< m, of their heights
  double highest = 0.0;  ///< m

  std::size_t size() const { return last - first; }
};

/// The windows of that width that begin at each of the readings, which are sorted by distance.
std::vector<Window> windows_of(const std::vector<Reading>& readings, double width) {
  std::vector<Window> windows;
  std::size_t last = 0;
  for (std::size_t first = 0; first < readings.size(); ++first) {
    while (last < readings.size() && readings[last].distance <= readings[first].distance + width) ++last;
    const auto [low, high] = std::minmax_element(
        readings.begin() + static_cast<std::ptrdiff_t>(first),
        readings.begin() + static_cast<std::ptrdiff_t>(last),
        [](const Reading& left, const Reading& right) { return left.height < right.height; });
    windows.push_back({first, last, low->height, high->height});
  }
  return windows;
}

/// The nearest window that holds at least half as many readings as the fullest; none of them ends at the edge
/// of a surface.
std::optional<Window> nearest_full(const std::vector<Window>& windows) {
  std::size_t most = 0;
  for (const Window& window : windows) most = std::max(most, window.size());
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const bool grows = i + 1 < windows.size() && windows[i + 1].last > windows[i].last;
    if (2 * windows[i].size() >= most && !grows) return windows[i];
  }
  return std::nullopt;
}

std::optional<OutlinePoint> upright_surface(std::vector<Reading>* readings, double bearing, double lowest,
                                            const DepthNoise& noise, const UprightOutlineOptions& options) {
  if (readings->empty()) return std::nullopt;
  std::sort(readings->begin(), readings->end(),
            [](const Reading& left, const Reading& right) { return left.distance < right.distance; });
  const Reading& nearest = readings->front();
  const double level_share = nearest.distance / nearest.depth;  // of an error in depth
  const double width = options.window + 2.0 * noise.step(nearest.depth) * level_share;
  std::vector<Window> windows = windows_of(*readings, width);
  windows.erase(std::remove_if(windows.begin(), windows.end(),
                               [&](const Window& window) {
                                 return window.highest - window.lowest < options.smallest_height ||
                                        window.lowest > lowest + options.largest_base;
                               }),
                windows.end());
  const auto window = nearest_full(windows);
  if (!window) return std::nullopt;
  double distance = 0.0;
  double depth = 0.0;
  const auto count = static_cast<double>(window->size());
  for (std::size_t i = window->first; i < window->last; ++i) {
    distance += (*readings)[i].distance / count;
    depth += (*readings)[i].depth / count;
  }
  const double variance = noise.mean_variance(depth, static_cast<int>(window->size()));
  return OutlinePoint{distance * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)),
                      std::hypot(std::sqrt(variance) * level_share, options.roughness),
                      options.sigma_aside * depth};
}

}  // namespace

PlanView::PlanView(const SupportPlane& plane) : camera_height_(plane.camera_height) {
  // Ahead is where the camera looks; when it looks down, where its picture's upper side is.
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() - plane.up.z() * plane.up;
  if (ahead.norm() < 0.1) ahead = -Eigen::Vector3d::UnitY() + plane.up.y() * plane.up;
  ahead.normalize();
  optical_from_plan_ << ahead, plane.up.cross(ahead), plane.up;
}

PlanPoint PlanView::view(const Eigen::Vector3d& point_in_optical, int index) const {
  const Eigen::Vector3d point = optical_from_plan_.transpose() * point_in_optical;
  return {point.head<2>(), point.z() + camera_height_, point_in_optical.z(), index};
}

Eigen::Vector3d PlanView::to_optical(const Eigen::Vector2d& place, double height) const {
  return optical_from_plan_ * Eigen::Vector3d(place.x(), place.y(), height - camera_height_);
}

Outline upright_outline(const std::vector<PlanPoint>& points, double bin_width, const DepthNoise& noise,
                        const UprightOutlineOptions& options) {
  const auto bearing_of = [](const PlanPoint& point) { return std::atan2(point.place.y(), point.place.x()); };
  std::vector<double> bearings;
  bearings.reserve(points.size());
  for (const PlanPoint& point : points) bearings.push_back(bearing_of(point));
  if (bearings.empty()) return {};
  const auto [right, left] = std::minmax_element(bearings.begin(), bearings.end());
  std::vector<std::vector<Reading>> bins(static_cast<std::size_t>((*left - *right) / bin_width) + 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    auto& bin = bins[static_cast<std::size_t>((*left - bearings[i]) / bin_width)];
    bin.push_back({points[i].place.norm(), points[i].height, points[i].depth});
  }
  double lowest = points.front().height;
  for (const PlanPoint& point : points) lowest = std::min(lowest, point.height);
  Outline outline;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const double bearing = *left - (static_cast<double>(i) + 0.5) * bin_width;
    if (const auto point = upright_surface(&bins[i], bearing, lowest, noise, options))
      outline.push_back(*point);
  }
  const auto edge = std::min(static_cast<std::size_t>(options.edge), outline.size() / 2);
  return {outline.begin() + static_cast<std::ptrdiff_t>(edge),
          outline.end() - static_cast<std::ptrdiff_t>(edge)};
}

}  // namespace kinect_ekf_slam
