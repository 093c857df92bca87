#include "kinect_ekf_slam/simulation/evaluation.h"

#include <algorithm>
#include <cmath>

namespace kinect_ekf_slam {
namespace {

constexpr int kMostRounds = 20;  // of matching and alignment; two or three are usual

struct Pairs {
  Points2d truth;
  Points2d estimate;
};

Eigen::Vector2d mean(const Points2d& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

std::size_t nearest(const Points2d& points, const Eigen::Vector2d& place) {
  const auto closer = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (a - place).squaredNorm() < (b - place).squaredNorm();
  };
  return static_cast<std::size_t>(std::min_element(points.begin(), points.end(), closer) - points.begin());
}

/// The mutual nearest neighbours, the estimate moved by `truth_from_estimate`.
Pairs match(const Points2d& truth, const Points2d& estimate, const Se2& truth_from_estimate,
            double largest_distance) {
  Pairs pairs;
  Points2d moved;
  for (const Eigen::Vector2d& point : estimate) moved.push_back(truth_from_estimate * point);
  for (std::size_t i = 0; i < truth.size() && !moved.empty(); ++i) {
    const std::size_t k = nearest(moved, truth[i]);
    if ((moved[k] - truth[i]).norm() > largest_distance || nearest(truth, moved[k]) != i) continue;
    pairs.truth.push_back(truth[i]);
    pairs.estimate.push_back(estimate[k]);
  }
  return pairs;
}

}  // namespace

Se2 align(const Points2d& target, const Points2d& source) {
  if (source.empty()) return {};
  const Eigen::Vector2d target_mean = mean(target);
  const Eigen::Vector2d source_mean = mean(source);
  double sine = 0.0;
  double cosine = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector2d a = source[i] - source_mean;
    const Eigen::Vector2d b = target[i] - target_mean;
    cosine += a.dot(b);
    sine += a.x() * b.y() - a.y() * b.x();
  }
  const Se2 turn(0.0, 0.0, std::atan2(sine, cosine));
  return {target_mean - turn * source_mean, turn.angle()};
}

MapComparison compare_maps(const Points2d& truth, const Points2d& estimate, double largest_distance) {
  Pairs pairs = match(truth, estimate, Se2(), largest_distance);
  Se2 motion = align(pairs.truth, pairs.estimate);
  for (int round = 0; round < kMostRounds; ++round) {
    Pairs again = match(truth, estimate, motion, largest_distance);
    const bool settled = again.truth == pairs.truth && again.estimate == pairs.estimate;
    pairs = std::move(again);
    motion = align(pairs.truth, pairs.estimate);
    if (settled) break;
  }
  MapComparison comparison;
  comparison.true_landmarks = truth.size();
  comparison.estimated_landmarks = estimate.size();
  comparison.matched = pairs.truth.size();
  double aligned = 0.0;
  double unaligned = 0.0;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    const double error = (motion * pairs.estimate[i] - pairs.truth[i]).norm();
    aligned += error * error;
    unaligned += (pairs.estimate[i] - pairs.truth[i]).squaredNorm();
    comparison.max_aligned = std::max(comparison.max_aligned, error);
  }
  const auto count = static_cast<double>(comparison.matched);
  comparison.rmse_aligned = std::sqrt(aligned / count);
  comparison.rmse = std::sqrt(unaligned / count);
  if (pairs.truth.empty()) comparison.max_aligned = std::nan("");
  return comparison;
}

}  // namespace kinect_ekf_slam
