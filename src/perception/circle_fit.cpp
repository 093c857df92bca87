#include "kinect_ekf_slam/perception/circle_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kTiny = 1e-9;  // m

/// Standard deviation of a point's distance from a surface with that normal, whatever its sign.
double sigma_across(const OutlinePoint& point, const Eigen::Vector2d& normal) {
  const double cosine = normal.dot(point.position.normalized());
  const double variance = cosine * cosine * point.sigma * point.sigma +
                          (1.0 - cosine * cosine) * point.sigma_aside * point.sigma_aside;
  return std::sqrt(std::max(variance, kTiny * kTiny));
}

Eigen::Vector3d algebraic_circle(const Outline& outline) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const OutlinePoint& point : outline) mean += point.position / static_cast<double>(outline.size());
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const OutlinePoint& point : outline) {
    const Eigen::Vector2d offset = point.position - mean;
    const Eigen::Vector3d row(2.0 * offset.x(), 2.0 * offset.y(), 1.0);
    normal_matrix += row * row.transpose();
    right_side += row * offset.squaredNorm();
  }
  const Eigen::Vector3d solution = normal_matrix.colPivHouseholderQr().solve(right_side);
  const Eigen::Vector2d center = mean + solution.head<2>();
  return {center.x(), center.y(), std::sqrt(std::max(solution.z() + solution.head<2>().squaredNorm(), 0.0))};
}

/// Just behind the surface that the sensor sees.
Eigen::Vector3d circle_behind(const Outline& outline, double radius) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const OutlinePoint& point : outline) mean += point.position / static_cast<double>(outline.size());
  const Eigen::Vector2d center = mean * (1.0 + radius / std::max(mean.norm(), kTiny));
  return {center.x(), center.y(), radius};
}

/// Sums over the points of a straight piece.
struct Moments {
  double count = 0.0;
  double sigma = 0.0;
  double sigma_aside = 0.0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();

  Moments with(const OutlinePoint& point) const {
    return {count + 1.0, sigma + point.sigma, sigma_aside + point.sigma_aside, first + point.position,
            second + point.position * point.position.transpose()};
  }
  Moments without(const Moments& part) const {
    return {count - part.count, sigma - part.sigma, sigma_aside - part.sigma_aside, first - part.first,
            second - part.second};
  }
};

/// Sum of the squared residuals from the best straight line.
double line_chi_square(const Moments& moments) {
  const Eigen::Vector2d mean = moments.first / moments.count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(moments.second - moments.first * mean.transpose());
  const OutlinePoint typical{mean, moments.sigma / moments.count, moments.sigma_aside / moments.count};
  const double sigma = sigma_across(typical, solver.eigenvectors().col(0));
  return std::max(0.0, solver.eigenvalues()(0)) / (sigma * sigma);
}

}  // namespace

double Circle::residual(const OutlinePoint& point) const {
  const Eigen::Vector2d offset = point.position - center;
  const double distance = std::max(offset.norm(), kTiny);
  return (distance - radius) / sigma_across(point, offset / distance);
}

double Circle::bearing(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d offset = point - center;
  return std::atan2(center.x() * offset.y() - center.y() * offset.x(), -center.dot(offset));
}

double Arc::symmetry() const { return std::clamp(std::min(left, right) / std::max(left, right), 0.0, 1.0); }

bool Arc::is_hollow() const {
  constexpr double kFarthestSeen = 1.8;  // rad; a quarter turn, and some noise
  return std::max(left, right) > kFarthestSeen;
}

Arc arc_of(const Circle& circle, const Outline& outline) {
  Arc arc{-kPi, -kPi};
  for (const OutlinePoint& point : outline) {
    const double bearing = circle.bearing(point.position);
    arc.left = std::max(arc.left, bearing);
    arc.right = std::max(arc.right, -bearing);
  }
  return arc;
}

std::optional<Circle> fit_circle(const Outline& outline, const RadiusBounds& bounds) {
  constexpr int kIterations = 50;
  constexpr double kConverged = 1e-7;  // m
  constexpr double kDiverged = 10.0;   // m
  if (outline.size() < 3) return std::nullopt;
  Eigen::Vector3d state = algebraic_circle(outline);
  if (!bounds.contain(state.z())) state = circle_behind(outline, bounds.mean());

  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double prior_weight = 1.0 / (bounds.sigma() * bounds.sigma());
    Eigen::Matrix3d information = Eigen::Vector3d(0.0, 0.0, prior_weight).asDiagonal();
    Eigen::Vector3d gradient(0.0, 0.0, prior_weight * (state.z() - bounds.mean()));
    double chi_square = 0.0;
    for (const OutlinePoint& point : outline) {
      const Eigen::Vector2d offset = point.position - state.head<2>();
      const double distance = std::max(offset.norm(), kTiny);
      const Eigen::Vector2d normal = offset / distance;
      const double sigma = sigma_across(point, normal);
      const Eigen::Vector3d jacobian = Eigen::Vector3d(-normal.x(), -normal.y(), -1.0) / sigma;
      const double residual = (distance - state.z()) / sigma;
      information += jacobian * jacobian.transpose();
      gradient += jacobian * residual;
      chi_square += residual * residual;
    }
    const Eigen::LDLT<Eigen::Matrix3d> decomposed(information);
    if (!decomposed.isPositive() || decomposed.rcond() < 1e-12) return std::nullopt;
    const Eigen::Vector3d step = -decomposed.solve(gradient);
    state += step;
    if (!state.allFinite() || step.norm() > kDiverged) return std::nullopt;
    if (step.norm() < kConverged) {
      const Eigen::Matrix3d covariance = decomposed.solve(Eigen::Matrix3d::Identity());
      return Circle{state.head<2>(), state.z(), 0.5 * (covariance + covariance.transpose()), chi_square};
    }
  }
  return std::nullopt;
}

double corner_chi_square(const Outline& outline) {
  constexpr std::size_t kShortest = 3;
  if (outline.size() < 2 * kShortest) return std::numeric_limits<double>::infinity();
  std::vector<Moments> upto{Moments()};
  for (const OutlinePoint& point : outline) upto.push_back(upto.back().with(point));
  double best = line_chi_square(upto.back());
  for (std::size_t split = kShortest; split + kShortest <= outline.size(); ++split) {
    best = std::min(best, line_chi_square(upto[split]) + line_chi_square(upto.back().without(upto[split])));
  }
  return best;
}

}  // namespace kinect_ekf_slam
