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
    const Landmark* landmark = particles_[m].path.landmark(track);
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
PathParticle<Space> FastSlam<Space>::present(const Particle& particle) const {
  PathParticle<Space> present = particle.path;
  present.move(motion_);
  return present;
}

/// The covariance is that within the particles plus that between them.
template <class Space>
PoseEstimate<Space> FastSlam<Space>::pose() const {
  std::vector<Pose> poses;
  poses.reserve(particles_.size());
  typename Space::PoseMatrix within = Space::PoseMatrix::Zero();
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    const PoseEstimate<Space> pose = present(particles_[m]).pose();
    poses.push_back(pose.map_from_base);
    within += weights_[m] * pose.covariance;
  }
  PoseEstimate<Space> estimate = mean_of_poses<Space>(poses, weights_);
  const typename Space::PoseMatrix covariance = estimate.covariance + within;
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

/// Adds `weight` times the covariances of a particle's pose and window to those of the state whose landmarks
/// are `tracks`, in ascending order; but for the pose's, and below the diagonal only.
template <class Space>
void FastSlam<Space>::add_window(const PathParticle<Space>& path, double weight,
                                 const std::vector<int>& tracks, Eigen::MatrixXd* covariance) {
  const auto row_of = [&](int track) -> std::optional<int> {
    const auto found = std::lower_bound(tracks.begin(), tracks.end(), track);
    if (found == tracks.end() || *found != track) return std::nullopt;
    return PathParticle<Space>::row(static_cast<std::size_t>(found - tracks.begin()));
  };
  const std::vector<int>& window = path.window();
  for (std::size_t i = 0; i < window.size(); ++i) {
    const auto row = row_of(window[i]);
    if (!row) continue;
    const auto from = path.covariance().template middleRows<kPointDim>(PathParticle<Space>::row(i));
    auto to = covariance->template middleRows<kPointDim>(*row);
    to.template leftCols<kPoseDim>() += weight * from.template leftCols<kPoseDim>();
    for (std::size_t j = 0; j < window.size(); ++j) {
      const auto column = row_of(window[j]);
      if (!column || *column > *row) continue;
      to.template middleCols<kPointDim>(*column) +=
          weight * from.template middleCols<kPointDim>(PathParticle<Space>::row(j));
    }
  }
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
  // P = sum of e e^T, of the particles' errors e times the roots of their weights, and what each particle
  // leaves open; on the diagonal that is known already.
  Eigen::MatrixXd errors =
      Eigen::MatrixXd::Zero(kPoseDim + rows, static_cast<Eigen::Index>(particles_.size()));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kPoseDim + rows, kPoseDim + rows);
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    const PathParticle<Space> path = present(particles_[m]);
    auto error = errors.col(static_cast<Eigen::Index>(m));
    error.template head<kPoseDim>() = pose_error<Space>(now.map_from_base, path.pose().map_from_base);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const Landmark* landmark = path.landmark(tracks[i]);
      if (landmark == nullptr) continue;
      error.template segment<kPointDim>(PathParticle<Space>::row(i)) = landmark->mean - means[i].mean;
    }
    error *= std::sqrt(weights_[m]);
    add_window(path, weights_[m], tracks, &covariance);
  }
  covariance.template selfadjointView<Eigen::Lower>().rankUpdate(errors);
  covariance.template topLeftCorner<kPoseDim, kPoseDim>() = now.covariance;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    state.landmarks_in_map.template segment<kPointDim>(kPointDim * i) = means[i].mean;
    const auto row = PathParticle<Space>::row(i);
    covariance.template block<kPointDim, kPointDim>(row, row) = means[i].covariance;
  }
  state.covariance = covariance.template selfadjointView<Eigen::Lower>();
  return state;
}

template <class Space>
void FastSlam<Space>::restore(const SlamState<Space>& state) {
  const PathParticle<Space> undrawn(state);
  for (Particle& particle : particles_) particle = {undrawn, {}, 0.0, 0};
  draw_poses(0);
  std::fill(weights_.begin(), weights_.end(), 1.0 / static_cast<double>(weights_.size()));
  motion_ = {};
  ids_.clear();
  contradictions_.clear();
  tracks_.assign(state.infos.size(), {});
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].info = state.infos[i];
    ids_.take(state.infos[i].id);
    bound(static_cast<int>(i));
  }
  if (fixed_map_) fix_map(state);
}

template <class Space>
void FastSlam<Space>::set_pose(const PoseEstimate<Space>& pose) {
  for (Particle& particle : particles_) particle.path.set_pose(pose.map_from_base);
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
