#include "kinect_ekf_slam/perception/cylinder_wall.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinect_ekf_slam {
namespace {

constexpr double kFacing = 1.2;        // rad from the direction to the camera; beyond, rays graze
constexpr double kTolerance = 0.004;   // m, of a point or ring; at a distance the depth's noise is added
constexpr double kRingNoise = 0.35;    // of a ring's median, as a share of that of one point
constexpr double kRingHeight = 0.006;  // m; at a distance two points of the cloud
constexpr std::size_t kFewest = 3;     // points of a ring
constexpr int kGap = 3;  // rings further up that the wall may go on: a shiny stripe has no depth

/// The points between two heights near the circle, on the side of the camera.
struct Ring {
  std::vector<double> offsets;  ///< m outside the circle
  std::vector<const PlanPoint*> points;

  double median_offset() const {
    std::vector<double> values = offsets;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }
};

std::vector<Ring> rings_of(const std::vector<PlanPoint>& points, const Circle& circle, double tolerance,
                           double ring_height) {
  std::vector<Ring> rings;
  for (const PlanPoint& point : points) {
    const double offset = (point.place - circle.center).norm() - circle.radius;
    if (std::abs(circle.bearing(point.place)) > kFacing || std::abs(offset) > 3.0 * tolerance) continue;
    const auto ring = static_cast<std::size_t>(std::max(0.0, point.height / ring_height));
    if (rings.size() <= ring) rings.resize(ring + 1);
    rings[ring].offsets.push_back(offset);
    rings[ring].points.push_back(&point);
  }
  return rings;
}

/// Slope of the straight line through (height, offset).
double slope(const std::vector<Eigen::Vector2d>& samples) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& sample : samples) mean += sample / static_cast<double>(samples.size());
  double covariance = 0.0;
  double variance = 0.0;
  for (const Eigen::Vector2d& sample : samples) {
    covariance += (sample.x() - mean.x()) * (sample.y() - mean.y());
    variance += (sample.x() - mean.x()) * (sample.x() - mean.x());
  }
  return variance > 0.0 ? covariance / variance : 0.0;
}

}  // namespace

CylinderWall follow_wall(const std::vector<PlanPoint>& points, const Circle& circle, const DepthNoise& noise,
                         double footprint) {
  const double distance = circle.center.norm();
  const double tolerance = kTolerance + noise.step(distance);
  const double ring_tolerance = kTolerance + kRingNoise * noise.step(distance);
  const double ring_height = std::max(kRingHeight, 2.0 * footprint * distance);
  const std::vector<Ring> rings = rings_of(points, circle, tolerance, ring_height);
  const auto is_seen = [](const Ring& ring) { return ring.points.size() >= kFewest; };
  const auto on_circle = [&](const Ring& ring) {
    return is_seen(ring) && std::abs(ring.median_offset()) <= ring_tolerance;
  };
  const auto first = std::find_if(rings.begin(), rings.end(), on_circle);
  auto last = first;
  for (auto ring = first; ring != rings.end() && ring - last <= kGap; ++ring) {
    if (on_circle(*ring)) {
      last = ring;
    } else if (is_seen(*ring)) {
      break;
    }
  }

  CylinderWall wall;
  if (first == rings.end()) return wall;
  wall.base = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector2d> samples;
  const auto rim = last + 1 == rings.end() ? last : last + 1;  // where the lid may have most of the points
  for (auto ring = first; ring <= rim; ++ring) {
    for (std::size_t i = 0; i < ring->points.size(); ++i) {
      if (std::abs(ring->offsets[i]) > tolerance) continue;
      wall.base = std::min(wall.base, ring->points[i]->height);
      wall.top = std::max(wall.top, ring->points[i]->height);
      wall.indices.push_back(ring->points[i]->index);
    }
    if (ring < last && on_circle(*ring)) {
      samples.emplace_back(static_cast<double>(ring - rings.begin()) * ring_height, ring->median_offset());
    }
  }
  wall.taper = slope(samples);
  std::size_t outside = 0;
  std::size_t all = 0;
  for (const PlanPoint& point : points) {
    if (point.height > wall.top) continue;
    ++all;
    outside += (point.place - circle.center).norm() > circle.radius + 3.0 * tolerance ? 1 : 0;
  }
  wall.share_outside = all > 0 ? static_cast<double>(outside) / static_cast<double>(all) : 0.0;
  return wall;
}

}  // namespace kinect_ekf_slam
