#include "kinect_ekf_slam/pipeline/global_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"

namespace kinect_ekf_slam {
namespace {

constexpr std::size_t kMostPairs = 400;
constexpr double kFitProbability = 0.999;
constexpr std::size_t kPairsAnOutlier = 4;  // of so many pairs one may be an outlier

}  // namespace

template <class Space>
struct GlobalAlignment<Space>::Fit {
  static constexpr int kUnknowns = Space::kPointDim + 1;  // shift, and turn about the vertical
  using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
  using UnknownsMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  double turn = 0.0;  ///< rad, from the global frame to the map
  Point shift = Point::Zero();
  UnknownsMatrix information = UnknownsMatrix::Zero();
  Unknowns gradient = Unknowns::Zero();
  double squared_residuals = 0.0;
  std::size_t worst = 0;  ///< the pair that fits worst

  static PointMatrix rotation_by(double angle) {
    const Eigen::Matrix3d about_vertical = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).matrix();
    return about_vertical.topLeftCorner<Space::kPointDim, Space::kPointDim>();
  }
  void close_in(const std::vector<Pair>& pairs);
  void weigh(const std::vector<Pair>& pairs);
  void step();
  Solution solution() const;
};

template <class Space>
void GlobalAlignment<Space>::add(const Pair& pair) {
  pairs_.push_back(pair);
  if (pairs_.size() <= kMostPairs) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pairs_.size(); i += 2) pairs_[kept++] = pairs_[i];
  pairs_.resize(kept);
}

/// The closed form, by distances from the centres: equation (11.8).
template <class Space>
void GlobalAlignment<Space>::Fit::close_in(const std::vector<Pair>& pairs) {
  const double share = 1.0 / static_cast<double>(pairs.size());
  Point map_centre = Point::Zero();
  Point global_centre = Point::Zero();
  for (const Pair& pair : pairs) {
    map_centre += share * pair.antenna_in_map;
    global_centre += share * pair.position;
  }
  double sine = 0.0;
  double cosine = 0.0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector2d in_map = (pair.antenna_in_map - map_centre).template head<2>();
    const Eigen::Vector2d in_global = (pair.position - global_centre).template head<2>();
    sine += in_global.x() * in_map.y() - in_global.y() * in_map.x();
    cosine += in_global.dot(in_map);
  }
  turn = std::atan2(sine, cosine);
  shift = map_centre - rotation_by(turn) * global_centre;
}

/// Information and residuals with the covariances of both: equation (11.9).
template <class Space>
void GlobalAlignment<Space>::Fit::weigh(const std::vector<Pair>& pairs) {
  using Jacobian = Eigen::Matrix<double, Space::kPointDim, kUnknowns>;
  const PointMatrix rotation = rotation_by(turn);
  information.setZero();
  gradient.setZero();
  squared_residuals = 0.0;
  double largest = -1.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& pair = pairs[i];
    const Point residual = pair.antenna_in_map - (rotation * pair.position + shift);
    const Eigen::LLT<PointMatrix> covariance(pair.antenna_covariance +
                                             rotation * pair.position_covariance * rotation.transpose());
    Jacobian J;  // at the way: the noise of the positions is no way
    J << PointMatrix::Identity(), Space::by_turn(pair.antenna_in_map).template rightCols<1>();
    const Jacobian weighted = covariance.solve(J);
    information += J.transpose() * weighted;
    gradient += weighted.transpose() * residual;
    const double squared = residual.dot(covariance.solve(residual));
    squared_residuals += squared;
    if (squared > largest) {
      largest = squared;
      worst = i;
    }
  }
}

template <class Space>
void GlobalAlignment<Space>::Fit::step() {
  const Unknowns step = information.ldlt().solve(gradient);
  if (!step.allFinite()) return;
  const double by = step(Space::kPointDim);
  shift = rotation_by(by) * shift + step.template head<Space::kPointDim>();
  turn = wrap_angle(turn + by);
}

template <class Space>
typename GlobalAlignment<Space>::Solution GlobalAlignment<Space>::Fit::solution() const {
  constexpr int kPointDim = Space::kPointDim;
  constexpr int kHeading = Space::kPoseDim - 1;
  const UnknownsMatrix covariance = information.ldlt().solve(UnknownsMatrix::Identity());
  Solution solution;
  solution.map_from_global.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).matrix();
  solution.map_from_global.translation() = Space::to_3d(shift);
  const auto place = [](int unknown) { return unknown < kPointDim ? unknown : kHeading; };
  for (int i = 0; i < kUnknowns; ++i) {
    for (int j = 0; j < kUnknowns; ++j) solution.covariance(place(i), place(j)) = covariance(i, j);
  }
  solution.heading_sigma = std::sqrt(covariance(kPointDim, kPointDim));
  return solution;
}

template <class Space>
std::optional<typename GlobalAlignment<Space>::Solution> GlobalAlignment<Space>::solve() const {
  constexpr std::size_t kFewest = 3;
  constexpr int kRounds = 2;
  std::vector<Pair> pairs = pairs_;
  const std::size_t fewest = std::max(kFewest, pairs.size() - pairs.size() / kPairsAnOutlier);
  while (pairs.size() >= fewest) {
    Fit fit;
    fit.close_in(pairs);
    for (int round = 0; round < kRounds; ++round) {
      fit.weigh(pairs);
      fit.step();
    }
    fit.weigh(pairs);
    const double dof = static_cast<double>(Space::kPointDim * pairs.size()) - Fit::kUnknowns;
    if (fit.squared_residuals <= chi_square_quantile(kFitProbability, dof)) {
      const Solution solution = fit.solution();
      const bool is_known = solution.covariance.allFinite() && solution.heading_sigma > 0.0;
      return is_known ? std::make_optional(solution) : std::nullopt;
    }
    pairs.erase(pairs.begin() + static_cast<std::ptrdiff_t>(fit.worst));
  }
  return std::nullopt;
}

template class GlobalAlignment<Planar>;
template class GlobalAlignment<Spatial>;

}  // namespace kinect_ekf_slam
