#include "kinect_ekf_slam/perception/two_views.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "kinect_ekf_slam/core/se3.h"

namespace kinect_ekf_slam {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using PixelByPoint = Eigen::Matrix<double, 2, 3>;
using PixelByMotion = Eigen::Matrix<double, 2, 6>;

constexpr int kIterations = 10;
constexpr double kNearest = 0.05;  // m of depth
constexpr double kGate = 13.8;     // chi-square quantile of 0.999 for a pixel's two axes

PixelByPoint projection_jacobian(const Eigen::Vector3d& point, const PinholeCamera& camera) {
  const double inverse = 1.0 / point.z();
  PixelByPoint jacobian;
  jacobian << camera.fx * inverse, 0.0, -camera.fx * point.x() * inverse * inverse, 0.0, camera.fy * inverse,
      -camera.fy * point.y() * inverse * inverse;
  return jacobian;
}

/// How a point moves under a small motion of its frame's contents.
Eigen::Matrix<double, 3, 6> point_by_motion(const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << Eigen::Matrix3d::Identity(), -hat(point);
  return jacobian;
}

Eigen::Isometry3d small_motion(const Vector6d& step) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translation() = step.head<3>();
  motion.linear() = rotation_exp(step.tail<3>()).toRotationMatrix();
  return motion;
}

/// The motion by RANSAC, unweighted.
std::optional<CameraMotion> sampled_motion(const std::vector<PlacedPoint>& points,
                                           const std::vector<Eigen::Vector2d>& pixels,
                                           const PinholeCamera& camera, const TwoViewOptions& options) {
  constexpr int kSamples = 200;
  constexpr double kConfidence = 0.999;
  std::vector<cv::Point3d> places;
  std::vector<cv::Point2d> seen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& place = points[i].position;
    places.emplace_back(place.x(), place.y(), place.z());
    seen.emplace_back(pixels[i].x(), pixels[i].y());
  }
  const cv::Matx33d matrix(camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0);
  cv::Vec3d rotation;
  cv::Vec3d translation;
  std::vector<int> inliers;
  const bool is_found = cv::solvePnPRansac(places, seen, matrix, cv::noArray(), rotation, translation, false,
                                           kSamples, static_cast<float>(options.reprojection_error),
                                           kConfidence, inliers, cv::SOLVEPNP_P3P);
  if (!is_found || static_cast<int>(inliers.size()) < options.fewest) return std::nullopt;
  CameraMotion motion;
  motion.second_from_first.translation() << translation[0], translation[1], translation[2];
  motion.second_from_first.linear() =
      rotation_exp(Eigen::Vector3d(rotation[0], rotation[1], rotation[2])).toRotationMatrix();
  motion.agrees.assign(points.size(), false);
  for (const int index : inliers) motion.agrees[index] = true;
  return motion;
}

/// Normal equations of the pixels' errors, J^T W J and J^T W e, about one motion, of the points that agree.
struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();
  Vector6d right_side = Vector6d::Zero();
};

/// Also decides anew which points agree, by what the noise of pixel and place allows.
NormalEquations linearise(CameraMotion* motion, const std::vector<PlacedPoint>& points,
                          const std::vector<Eigen::Vector2d>& pixels, const PinholeCamera& camera,
                          double pixel_variance) {
  NormalEquations equations;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d point = motion->second_from_first * points[i].position;
    motion->agrees[i] = false;
    if (point.z() < kNearest) continue;
    const PixelByPoint by_point = projection_jacobian(point, camera);
    const PixelByPoint by_place = by_point * motion->second_from_first.linear();
    const Eigen::Matrix2d noise =
        pixel_variance * Eigen::Matrix2d::Identity() + by_place * points[i].covariance * by_place.transpose();
    const Eigen::LLT<Eigen::Matrix2d> weight(noise);
    const Eigen::Vector2d error = pixels[i] - camera.project(point);
    motion->agrees[i] = error.dot(weight.solve(error)) < kGate;
    if (!motion->agrees[i]) continue;
    const PixelByMotion jacobian = by_point * point_by_motion(point);
    equations.information += jacobian.transpose() * weight.solve(jacobian);
    equations.right_side += jacobian.transpose() * weight.solve(error);
  }
  return equations;
}

}  // namespace

std::optional<CameraMotion> find_motion(const std::vector<PlacedPoint>& points_in_first,
                                        const std::vector<Eigen::Vector2d>& pixels_in_second,
                                        const PinholeCamera& camera, const TwoViewOptions& options) {
  if (static_cast<int>(points_in_first.size()) < options.fewest) return std::nullopt;
  auto motion = sampled_motion(points_in_first, pixels_in_second, camera, options);
  if (!motion) return std::nullopt;
  const double variance = options.pixel_sigma * options.pixel_sigma;
  for (int i = 0; i < kIterations; ++i) {
    const NormalEquations equations =
        linearise(&*motion, points_in_first, pixels_in_second, camera, variance);
    const Eigen::LLT<Matrix6d> factor(equations.information);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Vector6d step = factor.solve(equations.right_side);
    if (!step.allFinite()) return std::nullopt;
    motion->second_from_first = small_motion(step) * motion->second_from_first;
    motion->covariance = factor.solve(Matrix6d::Identity());
    if (step.norm() < 1e-9) break;
  }
  const auto agreeing = std::count(motion->agrees.begin(), motion->agrees.end(), true);
  if (agreeing < options.fewest) return std::nullopt;
  return motion;
}

std::optional<PlacedPoint> triangulate(const Eigen::Vector2d& pixel_in_first,
                                       const Eigen::Vector2d& pixel_in_second, const CameraMotion& motion,
                                       const PinholeCamera& camera, const TwoViewOptions& options) {
  const Eigen::Isometry3d first_from_second = motion.second_from_first.inverse();
  const Eigen::Matrix3d& rotation = first_from_second.linear();
  // The points nearest to each other on both rays: second ray times its depth, first centre plus first ray.
  const Eigen::Vector3d ray = camera.ray(pixel_in_second.x(), pixel_in_second.y());
  Eigen::Matrix<double, 3, 2> rays;
  rays << ray, -(motion.second_from_first.linear() * camera.ray(pixel_in_first.x(), pixel_in_first.y()));
  const Eigen::Vector2d depths =
      (rays.transpose() * rays).ldlt().solve(rays.transpose() * motion.second_from_first.translation());
  if (!depths.allFinite() || depths.minCoeff() < kNearest) return std::nullopt;

  PlacedPoint point{depths(0) * ray, {}};
  const Eigen::Matrix2d pixel_noise = options.pixel_sigma * options.pixel_sigma * Eigen::Matrix2d::Identity();
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector3d in_first = first_from_second * point.position;
    if (point.position.z() < kNearest || in_first.z() < kNearest) return std::nullopt;
    const PixelByPoint first = projection_jacobian(in_first, camera) * rotation;
    const PixelByPoint second = projection_jacobian(point.position, camera);
    const PixelByMotion by_motion = first * point_by_motion(point.position);
    const Eigen::LLT<Eigen::Matrix2d> first_weight(pixel_noise +
                                                   by_motion * motion.covariance * by_motion.transpose());
    const Eigen::LLT<Eigen::Matrix2d> second_weight(pixel_noise);
    const Eigen::Matrix3d information =
        first.transpose() * first_weight.solve(first) + second.transpose() * second_weight.solve(second);
    const Eigen::Vector3d right_side =
        first.transpose() * first_weight.solve(pixel_in_first - camera.project(in_first)) +
        second.transpose() * second_weight.solve(pixel_in_second - camera.project(point.position));
    const Eigen::LLT<Eigen::Matrix3d> factor(information);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Eigen::Vector3d step = factor.solve(right_side);
    point.position += step;
    point.covariance = factor.solve(Eigen::Matrix3d::Identity());
    if (step.norm() < 1e-9) break;
  }
  const double share = std::sqrt(point.covariance(2, 2)) / point.position.z();
  if (!point.position.allFinite() || point.position.z() < kNearest || !(share < options.largest_share)) {
    return std::nullopt;
  }
  point.covariance = 0.5 * (point.covariance + point.covariance.transpose().eval());
  return point;
}

}  // namespace kinect_ekf_slam
