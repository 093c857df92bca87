#include "kinect_ekf_slam/estimators/path_particle.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "kinect_ekf_slam/estimators/particles.h"

namespace kinect_ekf_slam {

template <class Space>
PathParticle<Space>::PathParticle(const SlamState<Space>& state)
    : map_from_base_(state.map_from_base), covariance_(state.covariance) {
  for (std::size_t i = 0; i < state.infos.size(); ++i) {
    window_.push_back(static_cast<int>(i));
    map_.set(window_.back(), {state.landmarks_in_map.template segment<kPointDim>(row(i) - kPoseDim),
                              state.covariance.template block<kPointDim, kPointDim>(row(i), row(i))});
  }
}

template <class Space>
void PathParticle<Space>::set_pose(const Pose& map_from_base) {
  map_from_base_ = map_from_base;
  covariance_.topRows(kPoseDim).setZero();
  covariance_.leftCols(kPoseDim).setZero();
}

template <class Space>
PredictedPoint<Space> PathParticle<Space>::predict(int track) const {
  PredictedPoint<Space> point = predict_point<Space>(map_from_base_, map_.find(track)->mean);
  point.by_pose *= local_from_error<Space>(map_from_base_);
  return point;
}

template <class Space>
int PathParticle<Space>::find_row(int track) const {
  const auto found = std::find(window_.begin(), window_.end(), track);
  return found == window_.end() ? -1 : row(static_cast<std::size_t>(found - window_.begin()));
}

template <class Space>
int PathParticle<Space>::join(int track) {
  const int found = find_row(track);
  if (found >= 0) return found;
  const auto rows = covariance_.rows();
  covariance_.conservativeResize(rows + kPointDim, rows + kPointDim);
  covariance_.bottomRows(kPointDim).setZero();
  covariance_.rightCols(kPointDim).setZero();
  if (const Landmark* landmark = map_.find(track)) {
    covariance_.template bottomRightCorner<kPointDim, kPointDim>() = landmark->covariance;
  }
  window_.push_back(track);
  return static_cast<int>(rows);
}

/// Equation (4.4): the window's landmarks stand still.
template <class Space>
void PathParticle<Space>::move(const MotionStep<Space>& step) {
  PoseEstimate<Space> moved = pose();
  const PoseMatrix F = predict_pose(step, &moved);
  map_from_base_ = moved.map_from_base;
  const auto landmarks = covariance_.rows() - kPoseDim;
  auto cross = covariance_.bottomLeftCorner(landmarks, kPoseDim);
  cross *= F.transpose();
  covariance_.topRightCorner(kPoseDim, landmarks) = cross.transpose();
  covariance_.template topLeftCorner<kPoseDim, kPoseDim>() = moved.covariance;
}

template <class Space>
typename PathParticle<Space>::Expectation PathParticle<Space>::expected(int track) const {
  const PredictedPoint<Space> point = predict(track);
  PointMatrix covariance = point.by_pose * pose().covariance * point.by_pose.transpose() +
                           point.by_landmark * map_.find(track)->covariance * point.by_landmark.transpose();
  if (const int row = find_row(track); row >= 0) {
    const PointMatrix mixed = point.by_landmark * covariance_.template block<kPointDim, kPoseDim>(row, 0) *
                              point.by_pose.transpose();
    covariance += mixed + mixed.transpose();
  }
  return {point.point_in_base, covariance};
}

template <class Space>
std::vector<std::optional<Fit>> PathParticle<Space>::correct(const std::vector<Sighting>& sightings) {
  for (const Sighting& sighting : sightings) join(sighting.track);
  std::vector<std::optional<Fit>> fits;
  Eigen::VectorXd error = Eigen::VectorXd::Zero(covariance_.rows());
  for (const Sighting& sighting : sightings) {
    const int row = find_row(sighting.track);
    const PredictedPoint<Space> point = predict(sighting.track);
    Eigen::Matrix<double, Eigen::Dynamic, kPointDim> gain =  // P H^T
        covariance_.template leftCols<kPoseDim>() * point.by_pose.transpose() +
        covariance_.template middleCols<kPointDim>(row) * point.by_landmark.transpose();
    const PointMatrix S = point.by_pose * gain.template topRows<kPoseDim>() +
                          point.by_landmark * gain.template middleRows<kPointDim>(row) + sighting.noise;
    const Point innovation = sighting.position_in_base - point.point_in_base -
                             point.by_pose * error.template head<kPoseDim>() -
                             point.by_landmark * error.template segment<kPointDim>(row);
    fits.push_back(fit_of<kPointDim>(innovation, S));
    if (!fits.back()) continue;
    const Eigen::LLT<PointMatrix> cholesky(S);  // S = L L^T
    const auto L = cholesky.matrixL();
    L.transpose().template solveInPlace<Eigen::OnTheRight>(gain);  // P H^T L^-T
    error += gain * L.solve(innovation);
    covariance_.noalias() -= gain * gain.transpose();
  }
  retract(error);
  return fits;
}

template <class Space>
void PathParticle<Space>::retract(const Eigen::VectorXd& error) {
  map_from_base_ = Space::retract(map_from_base_,
                                  local_from_error<Space>(map_from_base_) * error.template head<kPoseDim>());
  for (std::size_t i = 0; i < window_.size(); ++i) {
    const PointMatrix covariance = covariance_.template block<kPointDim, kPointDim>(row(i), row(i));
    map_.set(window_[i], {map_.find(window_[i])->mean + error.template segment<kPointDim>(row(i)),
                          covariance.template selfadjointView<Eigen::Lower>()});
  }
}

/// l = pose * z with its full cross-covariance, equations (4.11) and (4.12).
template <class Space>
void PathParticle<Space>::place(int track, const Observation<Space>& observation) {
  const PointMatrix by_measurement = map_from_base_.rotation();
  const typename Space::PointByPose by_pose = -by_measurement *
                                              Space::point_by_pose(observation.position_in_base) *
                                              local_from_error<Space>(map_from_base_);
  const int row = join(track);
  const Eigen::Matrix<double, kPointDim, Eigen::Dynamic> cross =
      by_pose * covariance_.template topRows<kPoseDim>();
  const PointMatrix covariance = by_pose * pose().covariance * by_pose.transpose() +
                                 by_measurement * observation.covariance * by_measurement.transpose();
  covariance_.template middleRows<kPointDim>(row) = cross;
  covariance_.template middleCols<kPointDim>(row) = cross.transpose();
  covariance_.template block<kPointDim, kPointDim>(row, row) = covariance;
  map_.set(track, {map_from_base_ * observation.position_in_base,
                   covariance.template selfadjointView<Eigen::Lower>()});
}

/// With P_xx = A A^T the pose is A w off; given that, the landmarks are P_lx A^-T w off, and as uncertain as
/// that leaves them. A = T L, L triangular in the robot's axes: how the map lies changes no draw.
template <class Space>
void PathParticle<Space>::draw(const PoseVector& white) {
  const PoseMatrix T = error_from_local<Space>(map_from_base_);
  const PoseMatrix L = covariance_root<PoseMatrix>(T.transpose() * pose().covariance * T);
  if (!L.isZero(0.0)) {
    const auto landmarks = covariance_.rows() - kPoseDim;
    Eigen::MatrixXd by_draw = covariance_.bottomLeftCorner(landmarks, kPoseDim) * T;
    L.transpose().template triangularView<Eigen::Upper>().template solveInPlace<Eigen::OnTheRight>(by_draw);
    covariance_.bottomRightCorner(landmarks, landmarks) -= by_draw * by_draw.transpose();
    Eigen::VectorXd error(covariance_.rows());
    error << T * L * white, by_draw * white;
    retract(error);
  }
  window_.clear();
  covariance_ = PoseMatrix::Zero();
}

template class PathParticle<Planar>;
template class PathParticle<Spatial>;

}  // namespace kinect_ekf_slam
