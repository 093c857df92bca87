#include "kinect_ekf_slam/fusion/alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"

namespace kinect_ekf_slam {
namespace {

template <class Space>
constexpr std::size_t kLeastPairs = static_cast<std::size_t>(Space::kPointDim);

/// Generalised least squares of g_k = T q_k + n, q = W s + o: the pairs in `used` count. Equation
/// (13.10).
template <class Space>
class Solver {
 public:
  static constexpr int kDim = Space::kPointDim;
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kTurnDim = Space::kTurnDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;

  Solver(const AlignmentPairs<Space>& pairs, const std::optional<HeadingPrior<Space>>& heading,
         std::vector<std::size_t> used)
      : pairs_(pairs), heading_(heading), used_(std::move(used)), points_(pairs.local_points) {}

  /// The weighted closed form; with a heading prior its turn, and the shift that belongs to it.
  void start() {
    Point global_mean = Point::Zero();
    Point local_mean = Point::Zero();
    double sum = 0.0;
    for (const std::size_t k : used_) {
      const double weight = 1.0 / pairs_.in_global[k].covariance.trace();
      global_mean += weight * pairs_.in_global[k].mean;
      local_mean += weight * place(k);
      sum += weight;
    }
    global_mean /= sum;
    local_mean /= sum;
    Pose turn =
        heading_ ? turn_of<Space>(heading_->global_from_local) : closed_form_turn(global_mean, local_mean);
    transform_ = translation_by<Space>(global_mean) * turn * translation_by<Space>(-local_mean);
  }

  /// Gauss and Newton over the transform and the points. False: the pairs leave some direction open.
  bool iterate() {
    constexpr int kMostRounds = 30;
    constexpr double kSettled = 1e-10;
    for (int round = 0; round < kMostRounds; ++round) {
      if (!linearize()) return false;
      transform_ = moved_by_error<Space>(transform_, step_);
      points_ = pairs_.local_points + gain_ * (residual_ - by_transform_ * step_);
      if (step_.norm() < kSettled) break;
    }
    return linearize();
  }

  typename Space::PoseMatrix transform_covariance() const { return transform_covariance_; }

  /// Squared distance of each pair's residual, chi-square with kDim degrees of freedom: the same as that of
  /// the pair's place from what all others say.
  std::vector<double> pair_distances() const {
    const Eigen::MatrixXd S = noise_ - by_transform_ * transform_covariance_ * by_transform_.transpose();
    const Eigen::VectorXd left = residual_;
    std::vector<double> distances;
    for (std::size_t j = 0; j < used_.size(); ++j) {
      const auto row = static_cast<Eigen::Index>(j) * kDim;
      const auto distance =
          squared_mahalanobis<kDim>(left.template segment<kDim>(row), S.template block<kDim, kDim>(row, row));
      distances.push_back(
          distance.value_or(0.0));  // singular: the only pair that knows; nothing contradicts it
    }
    return distances;
  }

  Alignment<Space> result() const {
    Alignment<Space> result;
    result.global_from_local = {transform_, transform_covariance_};
    result.local_points = points_;
    const Eigen::Index size = points_.size();
    result.covariance.resize(kPoseDim + size, kPoseDim + size);
    const Eigen::MatrixXd by_transform = gain_ * by_transform_;  // e_s = K (.) - K D e_T
    result.covariance.template topLeftCorner<kPoseDim, kPoseDim>() = transform_covariance_;
    result.covariance.bottomLeftCorner(size, kPoseDim) = -by_transform * transform_covariance_;
    result.covariance.bottomRightCorner(size, size) =
        pairs_.local_covariance - gain_ * noise_ * gain_.transpose() +
        by_transform * transform_covariance_ * by_transform.transpose();
    result.covariance = Eigen::MatrixXd(result.covariance.template selfadjointView<Eigen::Lower>());
    result.squared_distance = whitened_.squaredNorm();
    result.dof = kDim * static_cast<int>(used_.size()) - (heading_ ? kDim : kPoseDim);
    return result;
  }

  /// The place of a pair, used or not, as transform and points have it, in the global frame.
  Gaussian<Space::kPointDim> place_in_global(const Alignment<Space>& alignment, std::size_t pair) const {
    Eigen::MatrixXd by_all(kDim, alignment.covariance.cols());
    by_all << by_transform(pair), by_points(pair);
    Gaussian<Space::kPointDim> place;
    place.mean = transform_ * this->place(pair);
    place.covariance = by_all * alignment.covariance * by_all.transpose();
    return place;
  }

 private:
  /// q_k = sum_j w_kj s_j + o_k.
  Point place(std::size_t pair) const {
    const Eigen::Map<const Eigen::MatrixXd> points(points_.data(), kDim, points_.size() / kDim);
    const Point on_path = points * pairs_.weights.row(static_cast<Eigen::Index>(pair)).transpose();
    return pairs_.offsets.empty() ? on_path : Point(on_path + pairs_.offsets[pair].mean);
  }

  /// Of the global place, and of the offset as the transform turns it.
  typename Space::PointMatrix place_noise(std::size_t pair) const {
    typename Space::PointMatrix noise = pairs_.in_global[pair].covariance;
    if (!pairs_.offsets.empty()) {
      const typename Space::PointMatrix turn = transform_.rotation();
      noise += turn * pairs_.offsets[pair].covariance * turn.transpose();
    }
    return noise;
  }

  Pose closed_form_turn(const Point& global_mean, const Point& local_mean) const {
    typename Space::PointMatrix moments = Space::PointMatrix::Zero();
    for (const std::size_t k : used_) {
      const double weight = 1.0 / pairs_.in_global[k].covariance.trace();
      moments += weight * (pairs_.in_global[k].mean - global_mean) * (place(k) - local_mean).transpose();
    }
    const Eigen::JacobiSVD<typename Space::PointMatrix> svd(moments,
                                                            Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    Eigen::MatrixXd proper = Eigen::MatrixXd::Identity(kDim, kDim);  // a rotation, no reflection
    proper(kDim - 1, kDim - 1) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    turn.linear().template topLeftCorner<kDim, kDim>() = svd.matrixU() * proper * svd.matrixV().transpose();
    return Space::pose_from_3d(turn);
  }

  typename Space::PointByPose by_transform(std::size_t pair) const {
    return point_by_error<Space>(transform_, transform_ * place(pair));
  }

  Eigen::MatrixXd by_points(std::size_t pair) const {
    Eigen::MatrixXd jacobian(kDim, points_.size());
    for (Eigen::Index j = 0; j < pairs_.weights.cols(); ++j) {
      jacobian.template middleCols<kDim>(kDim * j) =
          pairs_.weights(static_cast<Eigen::Index>(pair), j) * transform_.rotation();
    }
    return jacobian;
  }

  bool linearize() {
    const Eigen::Index rows = static_cast<Eigen::Index>(used_.size()) * kDim;
    by_transform_.resize(rows, kPoseDim);
    Eigen::MatrixXd by_points(rows, points_.size());
    residual_.resize(rows);
    noise_.setZero(rows, rows);
    for (std::size_t j = 0; j < used_.size(); ++j) {
      const auto row = static_cast<Eigen::Index>(j) * kDim;
      const std::size_t pair = used_[j];
      by_transform_.template middleRows<kDim>(row) = by_transform(pair);
      by_points.template middleRows<kDim>(row) = this->by_points(pair);
      residual_.template segment<kDim>(row) = pairs_.in_global[pair].mean - transform_ * place(pair);
      noise_.template block<kDim, kDim>(row, row) = place_noise(pair);
    }
    const Eigen::MatrixXd cross = pairs_.local_covariance * by_points.transpose();
    noise_ += by_points * cross;  // S = A P A^T + R
    residual_ += by_points * (points_ - pairs_.local_points);
    const Eigen::LLT<Eigen::MatrixXd> root(noise_);
    if (root.info() != Eigen::Success) return false;
    gain_ = root.solve(cross.transpose()).transpose();
    return estimate_step(root);
  }

  /// The transform's step and its covariance, the points' errors taken into the noise.
  bool estimate_step(const Eigen::LLT<Eigen::MatrixXd>& root) {
    const Eigen::MatrixXd whitened = root.matrixL().solve(by_transform_);
    whitened_ = root.matrixL().solve(residual_);
    typename Space::PoseMatrix information = whitened.transpose() * whitened;
    typename Space::PoseVector pull = whitened.transpose() * whitened_;
    if (heading_) {
      const Eigen::LLT<TurnMatrix<Space>> prior(heading_->covariance);
      const auto error =
          turn_log<Space>(turn_of<Space>(heading_->global_from_local) * turn_of<Space>(transform_).inverse());
      information.template bottomRightCorner<kTurnDim, kTurnDim>() +=
          prior.solve(TurnMatrix<Space>::Identity());
      pull.template tail<kTurnDim>() += prior.solve(error);
    }
    const Eigen::LLT<typename Space::PoseMatrix> factor(information);
    if (factor.info() != Eigen::Success || !(factor.rcond() > kLeastRcond)) return false;
    step_ = factor.solve(pull);
    transform_covariance_ = factor.solve(Space::PoseMatrix::Identity());
    whitened_ -= whitened * step_;
    return true;
  }

  const AlignmentPairs<Space>& pairs_;
  const std::optional<HeadingPrior<Space>>& heading_;
  std::vector<std::size_t> used_;
  Pose transform_;
  Eigen::VectorXd points_;
  // At the present estimate; rows are those of the pairs.
  Eigen::MatrixXd by_transform_;  ///< D
  Eigen::VectorXd residual_;
  Eigen::MatrixXd noise_;  ///< S, of the residual, given the transform
  Eigen::MatrixXd gain_;   ///< K of the points
  Eigen::VectorXd whitened_;
  typename Space::PoseVector step_;
  typename Space::PoseMatrix transform_covariance_;
};

/// The worst pair goes, and with it those that are nearly as bad: one after the other would take a fit for
/// each where nothing agrees. The less bad ones may be so only because of the worst.
constexpr double kNearlyWorst = 0.5;

template <class Space>
void leave_out(const std::vector<double>& distances, double limit, std::vector<std::size_t>* used,
               std::vector<Disagreement<Space>>* disagreements) {
  std::vector<std::size_t> kept;
  for (std::size_t j = 0; j < used->size(); ++j) {
    const std::size_t pair = (*used)[j];
    if (distances[j] >= limit) {
      disagreements->push_back({pair, {}, {}, distances[j]});
    } else {
      kept.push_back(pair);
    }
  }
  *used = std::move(kept);
}

std::string degrees_text(double radians) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g deg", degrees(radians));
  return text;
}

/// Two places say how the plane is turned; in space a line leaves the turn about it.
template <class Space>
std::string open_turn() {
  return Space::kPointDim == 2 ? "the positions lie so near to one place that the heading"
                               : "the positions lie so near to one line that the turn about it";
}

}  // namespace

template <class Space>
AlignmentPairs<Space> AlignmentPairs<Space>::of_points(
    const std::vector<Gaussian<Space::kPointDim>>& in_local,
    const std::vector<Gaussian<Space::kPointDim>>& in_global) {
  constexpr int kDim = Space::kPointDim;
  const auto count = static_cast<Eigen::Index>(in_local.size());
  AlignmentPairs pairs;
  pairs.local_points.resize(kDim * count);
  pairs.local_covariance.setZero(kDim * count, kDim * count);
  pairs.weights.setIdentity(count, count);
  pairs.in_global = in_global;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Gaussian<kDim>& point = in_local[static_cast<std::size_t>(i)];
    pairs.local_points.template segment<kDim>(kDim * i) = point.mean;
    pairs.local_covariance.template block<kDim, kDim>(kDim * i, kDim * i) = point.covariance;
  }
  return pairs;
}

template <class Space>
AlignmentResult<Space> align_frames(const AlignmentPairs<Space>& pairs, const AlignmentOptions& options,
                                    const std::optional<HeadingPrior<Space>>& heading) {
  const double gate = chi_square_quantile(options.gate_probability, Space::kPointDim);
  const std::size_t least = heading ? 1 : kLeastPairs<Space>;
  std::vector<std::size_t> used(pairs.in_global.size());
  for (std::size_t k = 0; k < used.size(); ++k) used[k] = k;
  std::vector<Disagreement<Space>> disagreements;
  while (true) {
    if (used.size() < least || 2 * used.size() < pairs.in_global.size()) {
      return {std::nullopt, std::to_string(used.size()) + " of " + std::to_string(pairs.in_global.size()) +
                                " global positions agree, at least " + std::to_string(least) +
                                " and half of them are needed"};
    }
    Solver<Space> solver(pairs, heading, used);
    solver.start();
    if (!solver.iterate())
      return {std::nullopt, open_turn<Space>() + " is not known, a heading would say it"};
    const std::vector<double> distances = solver.pair_distances();
    const double worst = *std::max_element(distances.begin(), distances.end());
    if (worst >= gate) {
      leave_out(distances, std::max(gate, kNearlyWorst * worst), &used, &disagreements);
      continue;
    }
    const TurnMatrix<Space> turn =
        solver.transform_covariance().template bottomRightCorner<Space::kTurnDim, Space::kTurnDim>();
    const double sigma =
        std::sqrt(Eigen::SelfAdjointEigenSolver<TurnMatrix<Space>>(turn).eigenvalues().maxCoeff());
    if (!(sigma <= radians(options.max_turn_sigma_deg))) {
      return {std::nullopt, open_turn<Space>() + " is known to " + degrees_text(sigma) + " only, at most " +
                                degrees_text(radians(options.max_turn_sigma_deg)) + " are needed"};
    }
    Alignment<Space> alignment = solver.result();
    for (Disagreement<Space>& disagreement : disagreements) {
      disagreement.by_path = solver.place_in_global(alignment, disagreement.pair);
      disagreement.by_global_position = pairs.in_global[disagreement.pair];
    }
    alignment.disagreements = std::move(disagreements);
    return {std::move(alignment), ""};
  }
}

template struct AlignmentPairs<Planar>;
template struct AlignmentPairs<Spatial>;
template AlignmentResult<Planar> align_frames<Planar>(const AlignmentPairs<Planar>&, const AlignmentOptions&,
                                                      const std::optional<HeadingPrior<Planar>>&);
template AlignmentResult<Spatial> align_frames<Spatial>(const AlignmentPairs<Spatial>&,
                                                        const AlignmentOptions&,
                                                        const std::optional<HeadingPrior<Spatial>>&);

}  // namespace kinect_ekf_slam
