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
constexpr std::size_t kLeastShareOfOutliers = 4;  // one in

}  // namespace

template <class Space>
struct GlobalAlignment<Space>::Fit {
  static constexpr int kUnknowns = Space::kPointDim + 1;  // shift, and turn about the vertical
  double turn = 0.0;                                      ///< rad, from the global frame to the map
  Point shift = Point::Zero();
  Eigen::Matrix<double, kUnknowns, kUnknowns> information =
      Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  double squared_residuals = 0.0;
  std::size_t worst = 0;  ///< the pair that fits worst

  PointMatrix rotation() const {
    Eigen::Matrix3d about_vertical = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return about_vertical.topLeftCorner<Space::kPointDim, Space::kPointDim>();
  }
};

template <class Space>
void GlobalAlignment<Space>::add(const Pair& pair) {
  pairs_.push_back(pair);
  if (pairs_.size() <= kMostPairs) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pairs_.size(); i += 2) pairs_[kept++] = pairs_[i];
  pairs_.resize(kept);
}

/// The closed form by distances from the centres, equation (11.9), then Gauss-Newton with the covariances,
/// equation (11.10).
template <class Space>
typename GlobalAlignment<Space>::Fit GlobalAlignment<Space>::fit(const std::vector<Pair>& pairs) {
  constexpr int kPointDim = Space::kPointDim;
  Point map_centre = Point::Zero();
  Point global_centre = Point::Zero();
  for (const Pair& pair : pairs) {
    map_centre += pair.antenna_in_map / static_cast<double>(pairs.size());
    global_centre += pair.position / static_cast<double>(pairs.size());
  }
  double sine = 0.0;
  double cosine = 0.0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector2d in_map = (pair.antenna_in_map - map_centre).template head<2>();
    const Eigen::Vector2d in_global = (pair.position - global_centre).template head<2>();
    sine += in_global.x() * in_map.y() - in_global.y() * in_map.x();
    cosine += in_global.dot(in_map);
  }
  Fit fit;
  fit.turn = std::atan2(sine, cosine);
  fit.shift = map_centre - fit.rotation() * global_centre;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, Fit::kUnknowns, 1> gradient = Eigen::Matrix<double, Fit::kUnknowns, 1>::Zero();
    fit.information.setZero();
    fit.squared_residuals = 0.0;
    double largest = -1.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Pair& pair = pairs[i];
      const Point residual = pair.antenna_in_map - (fit.rotation() * pair.position + fit.shift);
      const PointMatrix covariance =
          pair.antenna_covariance + fit.rotation() * pair.position_covariance * fit.rotation().transpose();
      Eigen::Matrix<double, kPointDim, Fit::kUnknowns> J;  // at the way: noise of the positions is no way
      J << PointMatrix::Identity(), Space::by_turn(pair.antenna_in_map).template rightCols<1>();
      const Eigen::LLT<PointMatrix> cholesky(covariance);
      const Eigen::Matrix<double, kPointDim, Fit::kUnknowns> weighted = cholesky.solve(J);
      fit.information += J.transpose() * weighted;
      gradient += weighted.transpose() * residual;
      const double squared = residual.dot(cholesky.solve(residual));
      fit.squared_residuals += squared;
      if (squared > largest) {
        largest = squared;
        fit.worst = i;
      }
    }
    const Eigen::Matrix<double, Fit::kUnknowns, 1> step = fit.information.ldlt().solve(gradient);
    if (!step.allFinite() || round + 1 == kRounds) break;
    const double turn = step(kPointDim);
    Fit turned = fit;
    turned.turn = turn;
    fit.shift = turned.rotation() * fit.shift + step.template head<kPointDim>();
    fit.turn = wrap_angle(fit.turn + turn);
  }
  return fit;
}

template <class Space>
std::optional<typename GlobalAlignment<Space>::Solution> GlobalAlignment<Space>::solve() const {
  constexpr int kPointDim = Space::kPointDim;
  constexpr std::size_t kFewest = 3;
  std::vector<Pair> pairs = pairs_;
  const std::size_t fewest = std::max(kFewest, pairs.size() - pairs.size() / kLeastShareOfOutliers);
  for (; pairs.size() >= fewest;) {
    const Fit found = fit(pairs);
    const double dof = static_cast<double>(kPointDim * pairs.size()) - Fit::kUnknowns;
    if (found.squared_residuals <= chi_square_quantile(kFitProbability, dof)) {
      const Eigen::MatrixXd covariance =
          found.information.ldlt().solve(Eigen::MatrixXd::Identity(Fit::kUnknowns, Fit::kUnknowns));
      if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() > 0.0)) return std::nullopt;
      Solution solution;
      solution.map_from_global.linear() =
          Eigen::AngleAxisd(found.turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      solution.map_from_global.translation() = Space::to_3d(found.shift);
      constexpr int kHeading = Space::kPoseDim - 1;
      solution.covariance.template topLeftCorner<kPointDim, kPointDim>() =
          covariance.topLeftCorner(kPointDim, kPointDim);
      solution.covariance.template block<kPointDim, 1>(0, kHeading) =
          covariance.block(0, kPointDim, kPointDim, 1);
      solution.covariance.template block<1, kPointDim>(kHeading, 0) =
          covariance.block(kPointDim, 0, 1, kPointDim);
      solution.covariance(kHeading, kHeading) = covariance(kPointDim, kPointDim);
      solution.heading_sigma = std::sqrt(covariance(kPointDim, kPointDim));
      return solution;
    }
    pairs.erase(pairs.begin() + static_cast<std::ptrdiff_t>(found.worst));
  }
  return std::nullopt;
}

template class GlobalAlignment<Planar>;
template class GlobalAlignment<Spatial>;

}  // namespace kinect_ekf_slam
