#include "kinect_ekf_slam/perception/laser_cylinder.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

/// Rays of one surface, in their order; in a full turn they may go through the end of the scan.
using Run = std::vector<std::size_t>;

class ScanReader {
 public:
  ScanReader(const LaserScan& scan, const LaserCylinderOptions& options)
      : scan_(scan), options_(options), full_turn_(scan.is_full_turn()) {}

  std::vector<Run> runs() const {
    const std::size_t count = scan_.ranges.size();
    std::size_t first = 0;  // in a full turn, begin where a surface does
    while (full_turn_ && first < count && !breaks_before(first)) ++first;
    if (first == count) first = 0;
    std::vector<Run> runs;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t ray = (first + i) % count;
      if (!is_reading(ray)) continue;
      if (i == 0 || breaks_before(ray)) runs.emplace_back();
      runs.back().push_back(ray);
    }
    return runs;
  }

  /// Beyond both ends there is something farther, or nothing: no nearer object hides a part of this one.
  bool stands_free(const Run& run) const { return is_free(run.front(), -1) && is_free(run.back(), 1); }

  Outline outline(const Run& run) const {
    Outline outline;
    for (const std::size_t ray : run) {
      const double range = scan_.ranges[ray];
      const Eigen::Vector2d direction(std::cos(scan_.angle(ray)), std::sin(scan_.angle(ray)));
      outline.push_back({range * direction, options_.range_sigma, options_.sigma_aside * range});
    }
    return outline;
  }

 private:
  bool is_reading(std::size_t ray) const {
    const double range = scan_.ranges[ray];
    return range >= scan_.range_min && range <= scan_.range_max;
  }

  bool breaks_before(std::size_t ray) const {
    if (ray == 0 && !full_turn_) return true;
    const std::size_t before = (ray + scan_.ranges.size() - 1) % scan_.ranges.size();
    return !is_reading(ray) || !is_reading(before) ||
           std::abs(scan_.ranges[ray] - scan_.ranges[before]) > options_.jump;
  }

  bool is_free(std::size_t end, int step) const {
    const auto count = static_cast<std::ptrdiff_t>(scan_.ranges.size());
    const auto neighbour = static_cast<std::ptrdiff_t>(end) + step;
    if (!full_turn_ && (neighbour < 0 || neighbour >= count)) return false;  // cut by the border of the scan
    const double beyond = scan_.ranges[static_cast<std::size_t>((neighbour + count) % count)];
    return !(beyond < scan_.ranges[end]);  // what is too near for a reading hides as well
  }

  const LaserScan& scan_;
  const LaserCylinderOptions& options_;
  bool full_turn_;
};

double extent(const Outline& outline) {
  Eigen::Vector2d low = outline.front().position;
  Eigen::Vector2d high = low;
  for (const OutlinePoint& point : outline) {
    low = low.cwiseMin(point.position);
    high = high.cwiseMax(point.position);
  }
  return (high - low).maxCoeff();
}

/// Why a fitted circle is no cylinder; empty: it is one. A straight wall fits circles that are large for it
/// only: it fails by the length of the arc.
std::string reason_against(const Circle& circle, const Outline& outline, double range_max,
                           const LaserCylinderOptions& options) {
  if (!options.radius.contain(circle.radius)) return "radius";
  // The ends of the arc would be the scanner's, not the object's.
  if (circle.center.norm() + circle.radius > range_max) return "partly out of range";
  const Arc arc = arc_of(circle, outline);
  if (arc.is_hollow()) return "hollow";
  if (arc.whole() < options.min_arc) return "short arc";
  if (circle.chi_square > options.max_misfit * static_cast<double>(outline.size())) return "not round";
  return {};
}

Finding to_finding(const Circle& circle, double height_sigma) {
  Finding finding;
  finding.position << circle.center, 0.0;
  finding.covariance.topLeftCorner<2, 2>() = circle.covariance.topLeftCorner<2, 2>();
  finding.covariance(2, 2) = height_sigma * height_sigma;
  finding.signature.radius = circle.radius;
  return finding;
}

}  // namespace

bool LaserScan::is_full_turn() const {
  return (static_cast<double>(ranges.size()) + 0.5) * std::abs(angle_increment) >= 2.0 * kPi;
}

Findings find_cylinders(const LaserScan& scan, const LaserCylinderOptions& options) {
  const ScanReader reader(scan, options);
  Findings findings;
  for (const Run& run : reader.runs()) {
    if (static_cast<int>(run.size()) < std::max(options.min_points, 3)) continue;
    const Outline outline = reader.outline(run);
    if (extent(outline) > 2.0 * options.radius.max + 6.0 * options.range_sigma) continue;
    const Region region{static_cast<int>(run.front()), 0, static_cast<int>(run.size()), 1};
    const auto circle = fit_circle(outline, options.radius);
    std::string reason = !reader.stands_free(run) ? "partly hidden"
                         : !circle                ? "not round"
                                                  : reason_against(*circle, outline, scan.range_max, options);
    if (!reason.empty()) {
      findings.refused.push_back({std::move(reason), region});
      continue;
    }
    findings.found.push_back(to_finding(*circle, options.height_sigma));
    findings.found.back().region = region;
  }
  return findings;
}

}  // namespace kinect_ekf_slam
