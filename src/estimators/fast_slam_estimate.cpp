/// What FastSLAM's particles tell, and how they are made from what is told; fast_slam.cpp is the filter.
#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/estimators/fast_slam.h"

namespace kinect_ekf_slam {

template <class Space>
std::optional<typename FastSlam<Space>::Landmark> FastSlam<Space>::landmark(int track) const {
  std::vector<double> probabilities;
  std::vector<Landmark> parts;
  double weight = 0.0;
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    const Landmark* landmark = particles_[m].map.find(track);
    if (landmark == nullptr) continue;
    parts.push_back(*landmark);
    probabilities.push_back(weights_[m]);
    weight += weights_[m];
  }
  if (!(weight > 0.5)) return std::nullopt;
  for (double& probability : probabilities) probability /= weight;
  return moments_of_mixture(probabilities, parts);
}

template <class Space>
PoseEstimate<Space> FastSlam<Space>::pose() const {
  std::vector<Pose> poses;
  poses.reserve(particles_.size());
  typename Space::PoseMatrix undrawn = Space::PoseMatrix::Zero();
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    poses.push_back(particles_[m].map_from_base * motion_.delta);
    const auto T = error_from_local<Space>(poses.back());
    undrawn += weights_[m] * (T * motion_.covariance * T.transpose());
  }
  PoseEstimate<Space> estimate = mean_of_poses<Space>(poses, weights_);
  const typename Space::PoseMatrix covariance = estimate.covariance + undrawn;
  estimate.covariance = covariance.template selfadjointView<Eigen::Lower>();
  return estimate;
}

template <class Space>
std::vector<LandmarkEstimate<Space>> FastSlam<Space>::landmarks() const {
  std::vector<LandmarkEstimate<Space>> estimates;
  if (fixed_map_) {
    for (std::size_t i = 0; i < fixed_map_->infos.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(kPointDim * i);
      estimates.push_back(
          {fixed_map_->infos[i], fixed_map_->landmarks_in_map.template segment<kPointDim>(row),
           fixed_map_->covariance.template block<kPointDim, kPointDim>(kPoseDim + row, kPoseDim + row)});
    }
    return estimates;
  }
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    const auto found = landmark(static_cast<int>(track));
    if (found) estimates.push_back({tracks_[track].info, found->mean, found->covariance});
  }
  return estimates;
}

template <class Space>
SlamState<Space> FastSlam<Space>::snapshot() const {
  const PoseEstimate<Space> now = pose();
  if (fixed_map_) {  // the pose as if it were independent of the map
    SlamState<Space> state = *fixed_map_;
    state.map_from_base = now.map_from_base;
    state.covariance.template topLeftCorner<kPoseDim, kPoseDim>() = now.covariance;
    return state;
  }
  SlamState<Space> state;
  state.map_from_base = now.map_from_base;
  std::vector<Landmark> means;
  std::vector<int> tracks;
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    const auto found = landmark(static_cast<int>(track));
    if (!found) continue;
    tracks.push_back(static_cast<int>(track));
    means.push_back(*found);
    state.infos.push_back(tracks_[track].info);
  }
  const auto rows = static_cast<Eigen::Index>(kPointDim * tracks.size());
  state.landmarks_in_map.resize(rows);
  // P = sum of e e^T, of the particles' errors e times the roots of their weights, and on its diagonal the
  // covariances that are known anyway.
  Eigen::MatrixXd errors =
      Eigen::MatrixXd::Zero(kPoseDim + rows, static_cast<Eigen::Index>(particles_.size()));
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    auto error = errors.col(static_cast<Eigen::Index>(m));
    error.template head<kPoseDim>() =
        error_from_local<Space>(now.map_from_base) *
        local_difference<Space>(now.map_from_base, particles_[m].map_from_base * motion_.delta);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const Landmark* landmark = particles_[m].map.find(tracks[i]);
      if (landmark == nullptr) continue;
      error.template segment<kPointDim>(kPoseDim + kPointDim * i) = landmark->mean - means[i].mean;
    }
    error *= std::sqrt(weights_[m]);
  }
  Eigen::MatrixXd covariance = errors * errors.transpose();
  covariance.template topLeftCorner<kPoseDim, kPoseDim>() = now.covariance;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    state.landmarks_in_map.template segment<kPointDim>(kPointDim * i) = means[i].mean;
    const auto row = static_cast<Eigen::Index>(kPoseDim + kPointDim * i);
    covariance.template block<kPointDim, kPointDim>(row, row) = means[i].covariance;
  }
  state.covariance = covariance.template selfadjointView<Eigen::Lower>();
  return state;
}

template <class Space>
void FastSlam<Space>::restore(const SlamState<Space>& state) {
  const auto points = state.landmarks_in_map.size();
  // Given the pose's error A w, w white, the landmarks are P_lx A^-T w off, and as uncertain as that leaves
  // them.
  const typename Space::PoseMatrix P = state.covariance.template topLeftCorner<kPoseDim, kPoseDim>();
  const typename Space::PoseMatrix A = covariance_root(P);
  Eigen::MatrixXd by_pose = state.covariance.bottomLeftCorner(points, kPoseDim);
  if (A.isZero(0.0)) {
    by_pose.setZero();
  } else {
    A.transpose().template triangularView<Eigen::Upper>().template solveInPlace<Eigen::OnTheRight>(by_pose);
  }
  const Eigen::MatrixXd white = standardized_draws(kPoseDim, options_.particles, &random_);
  ids_.clear();
  contradictions_.clear();
  tracks_.assign(state.infos.size(), {});
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    const PoseVector w = white.col(static_cast<Eigen::Index>(m));
    particles_[m] = {};
    particles_[m].map_from_base =
        Space::retract(state.map_from_base, local_from_error<Space>(state.map_from_base) * A * w);
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(kPointDim * i);
      const auto gain = by_pose.template middleRows<kPointDim>(row);
      const PointMatrix covariance =
          state.covariance.template block<kPointDim, kPointDim>(kPoseDim + row, kPoseDim + row) -
          gain * gain.transpose();
      particles_[m].map.set(static_cast<int>(i),
                            {state.landmarks_in_map.template segment<kPointDim>(row) + gain * w,
                             covariance.template selfadjointView<Eigen::Lower>()});
    }
  }
  std::fill(weights_.begin(), weights_.end(), 1.0 / static_cast<double>(weights_.size()));
  motion_ = {};
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].info = state.infos[i];
    ids_.take(state.infos[i].id);
    bound(static_cast<int>(i));
  }
  if (fixed_map_) fix_map(state);
}

template <class Space>
void FastSlam<Space>::set_pose(const PoseEstimate<Space>& pose) {
  for (Particle& particle : particles_) {
    particle.map_from_base = pose.map_from_base;
    particle.error = {};
  }
  const typename Space::PoseMatrix to_local = local_from_error<Space>(pose.map_from_base);
  const typename Space::PoseMatrix covariance = to_local * pose.covariance * to_local.transpose();
  motion_ = {Pose(), covariance.template selfadjointView<Eigen::Lower>()};
}

template <class Space>
void FastSlam<Space>::fix_map(const SlamState<Space>& state) {
  fixed_map_ = state;
  fixed_map_->covariance.leftCols(kPoseDim).setZero();
  fixed_map_->covariance.topRows(kPoseDim).setZero();
}

template <class Space>
void FastSlam<Space>::set_map_fixed(bool fixed) {
  if (fixed == fixed_map_.has_value()) return;
  if (fixed) {
    fix_map(snapshot());
  } else {
    const SlamState<Space> state = snapshot();
    fixed_map_.reset();
    restore(state);
  }
}

template class FastSlam<Planar>;
template class FastSlam<Spatial>;

}  // namespace kinect_ekf_slam
