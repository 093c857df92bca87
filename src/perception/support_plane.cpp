#include "kinect_ekf_slam/perception/support_plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace kinect_ekf_slam {
namespace {

constexpr int kRefinements = 3;

/// A plane's distance from a point is noisy as far as the point's depth is: along the ray.
double tolerance_at(const Eigen::Vector3d& point, const Eigen::Vector3d& up, const DepthNoise& noise,
                    double tolerance) {
  return tolerance + 2.0 * noise.step(point.z()) * std::abs(up.dot(point)) / point.z();
}

/// Draws of three after which one has most likely hit points of the plane only.
double draws_needed(double share_in_plane) {
  constexpr double kMissed = 1e-3;  // probability
  const double hit = std::pow(share_in_plane, 3);
  return hit > 0.0 ? std::log(kMissed) / std::log1p(-std::min(hit, 0.99))
                   : std::numeric_limits<double>::infinity();
}

class PlaneSearch {
 public:
  PlaneSearch(const std::vector<Eigen::Vector3d>& points, const DepthNoise& noise,
              const SupportPlaneOptions& options)
      : points_(points), noise_(noise), options_(options), expected_up_(options.up_in_optical.normalized()) {}

  /// The plane with that normal line, its normal upwards; none when it is too steep or seen from below.
  std::optional<SupportPlane> level_plane(Eigen::Vector3d normal, const Eigen::Vector3d& point) const {
    if (normal.dot(expected_up_) < 0.0) normal = -normal;
    const SupportPlane plane{normal, -normal.dot(point)};
    if (normal.dot(expected_up_) < std::cos(options_.largest_tilt)) return std::nullopt;
    if (!(plane.camera_height > 0.0)) return std::nullopt;
    return plane;
  }

  bool contains(const SupportPlane& plane, const Eigen::Vector3d& point) const {
    return std::abs(plane.height_of(point)) < tolerance_at(point, plane.up, noise_, options_.tolerance);
  }

  std::size_t count(const SupportPlane& plane) const {
    std::size_t count = 0;
    for (const Eigen::Vector3d& point : points_) count += contains(plane, point) ? 1 : 0;
    return count;
  }

  /// Least squares over the plane's points, each weighted by its noise.
  std::optional<SupportPlane> refine(const SupportPlane& plane) const {
    double weights = 0.0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& point : points_) {
      if (!contains(plane, point)) continue;
      const double weight = 1.0 / noise_.mean_variance(point.z(), 1);
      weights += weight;
      first += weight * point;
      second += weight * point * point.transpose();
    }
    if (!(weights > 0.0)) return std::nullopt;
    const Eigen::Vector3d mean = first / weights;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(second - first * mean.transpose());
    return level_plane(solver.eigenvectors().col(0), mean);
  }

 private:
  const std::vector<Eigen::Vector3d>& points_;
  const DepthNoise& noise_;
  const SupportPlaneOptions& options_;
  Eigen::Vector3d expected_up_;
};

}  // namespace

std::optional<SupportPlane> find_support_plane(const std::vector<Eigen::Vector3d>& points_in_optical,
                                               const DepthNoise& noise, const SupportPlaneOptions& options) {
  if (points_in_optical.size() < 3) return std::nullopt;
  const PlaneSearch search(points_in_optical, noise, options);
  std::mt19937_64 random(options.seed);
  const auto draw = [&] { return points_in_optical[random() % points_in_optical.size()]; };

  std::optional<SupportPlane> best;
  std::size_t most = 0;
  const auto needed = [&] {
    return draws_needed(static_cast<double>(most) / static_cast<double>(points_in_optical.size()));
  };
  for (int i = 0; i < options.iterations && i < needed(); ++i) {
    const Eigen::Vector3d a = draw();
    const Eigen::Vector3d b = draw();
    const Eigen::Vector3d c = draw();
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (!(normal.norm() > 0.0)) continue;
    const auto plane = search.level_plane(normal.normalized(), a);
    const std::size_t count = plane ? search.count(*plane) : 0;
    if (count > most) {
      most = count;
      best = plane;
    }
  }
  for (int i = 0; best && i < kRefinements; ++i) best = search.refine(*best);
  if (!best) return std::nullopt;
  const double share =
      static_cast<double>(search.count(*best)) / static_cast<double>(points_in_optical.size());
  return share < options.smallest_share ? std::nullopt : best;
}

}  // namespace kinect_ekf_slam
