#include "kinect_ekf_slam/simulation/evaluation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace kinect_ekf_slam {
namespace {

constexpr int kMostRounds = 20;  // of matching and alignment; two or three are usual

template <class Space>
struct Pairs {
  Points<Space> truth;
  Points<Space> estimate;
  std::vector<std::pair<std::size_t, std::size_t>> indices;
};

template <class Space>
std::size_t nearest(const Points<Space>& points, const typename Space::Point& place) {
  const auto closer = [&](const auto& a, const auto& b) {
    return (a - place).squaredNorm() < (b - place).squaredNorm();
  };
  return static_cast<std::size_t>(std::min_element(points.begin(), points.end(), closer) - points.begin());
}

/// The mutual nearest neighbours, the estimate moved by `truth_from_estimate`.
template <class Space>
Pairs<Space> match(const Points<Space>& truth, const Points<Space>& estimate,
                   const typename Space::Pose& truth_from_estimate, double largest_distance) {
  Pairs<Space> pairs;
  Points<Space> moved;
  for (const auto& point : estimate) moved.push_back(truth_from_estimate * point);
  for (std::size_t i = 0; i < truth.size() && !moved.empty(); ++i) {
    const std::size_t k = nearest<Space>(moved, truth[i]);
    if ((moved[k] - truth[i]).norm() > largest_distance || nearest<Space>(truth, moved[k]) != i) continue;
    pairs.truth.push_back(truth[i]);
    pairs.estimate.push_back(estimate[k]);
    pairs.indices.emplace_back(i, k);
  }
  return pairs;
}

/// The points as columns.
template <class Space>
Eigen::Map<const Eigen::MatrixXd> columns(const Points<Space>& points) {
  return {points.front().data(), Space::kPointDim, static_cast<Eigen::Index>(points.size())};
}

}  // namespace

template <class Space>
typename Space::Pose align(const Points<Space>& target, const Points<Space>& source) {
  if (source.empty()) return {};
  constexpr int kDim = Space::kPointDim;
  const Eigen::MatrixXd motion = Eigen::umeyama(columns<Space>(source), columns<Space>(target), false);
  Eigen::Isometry3d in_space = Eigen::Isometry3d::Identity();
  in_space.linear().topLeftCorner<kDim, kDim>() = motion.topLeftCorner<kDim, kDim>();
  in_space.translation().head<kDim>() = motion.topRightCorner<kDim, 1>();
  return Space::pose_from_3d(in_space);
}

template <class Space>
MapComparison compare_maps(const Points<Space>& truth, const Points<Space>& estimate,
                           double largest_distance) {
  using Pose = typename Space::Pose;
  Pairs<Space> pairs = match<Space>(truth, estimate, Pose(), largest_distance);
  Pose motion = align<Space>(pairs.truth, pairs.estimate);
  for (int round = 0; round < kMostRounds; ++round) {
    Pairs<Space> again = match<Space>(truth, estimate, motion, largest_distance);
    const bool settled = again.truth == pairs.truth && again.estimate == pairs.estimate;
    pairs = std::move(again);
    motion = align<Space>(pairs.truth, pairs.estimate);
    if (settled) break;
  }
  MapComparison comparison;
  comparison.true_landmarks = truth.size();
  comparison.estimated_landmarks = estimate.size();
  comparison.matched = pairs.truth.size();
  comparison.pairs = pairs.indices;
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

template Se2 align<Planar>(const Points<Planar>&, const Points<Planar>&);
template Se3 align<Spatial>(const Points<Spatial>&, const Points<Spatial>&);
template MapComparison compare_maps<Planar>(const Points<Planar>&, const Points<Planar>&, double);
template MapComparison compare_maps<Spatial>(const Points<Spatial>&, const Points<Spatial>&, double);

}  // namespace kinect_ekf_slam
