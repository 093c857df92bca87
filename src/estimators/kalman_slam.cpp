#include "kinect_ekf_slam/estimators/kalman_slam.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

/// False where S = L L^T is singular to working precision: its condition is at least the square of the
/// largest over the smallest pivot.
bool is_regular(const Eigen::Ref<const Eigen::MatrixXd>& L) {
  const double ratio = L.diagonal().minCoeff() / L.diagonal().maxCoeff();
  return ratio * ratio > kLeastRcond;
}

/// rows <- rows U^-1. Some rows at a time: Eigen then works on the stack.
template <class Triangle, class Matrix>
void solve_on_the_right(const Triangle& U, Matrix* rows) {
  constexpr int kRows = 64;
  for (Eigen::Index row = 0; row < rows->rows(); row += kRows) {
    auto some = rows->middleRows(row, std::min<Eigen::Index>(kRows, rows->rows() - row));
    U.template solveInPlace<Eigen::OnTheRight>(some);
  }
}

}  // namespace

template <class Space>
typename Space::Point KalmanSlam<Space>::Expectation::point_in_base(int landmark) const {
  const GaussianState<Space>& state = filter_->state_;
  return predict_point<Space>(state.map_from_base(), state.landmark(landmark)).point_in_base;
}

/// H_a P H_b^T.
template <class Space>
typename Space::PointMatrix KalmanSlam<Space>::Expectation::cross_covariance(int a, int b) const {
  const GaussianState<Space>& state = filter_->state_;
  const Jacobian H_a = filter_->jacobian(state.landmark(a));
  const Jacobian H_b = a == b ? H_a : filter_->jacobian(state.landmark(b));
  return cross(H_a, H_b, state.pose_covariance(), state.landmark_by_pose(a), state.landmark_by_pose(b),
               state.landmark_covariance(a, b));
}

template <class Space>
void KalmanSlam<Space>::predict(const MotionStep<Space>& step) {
  PoseEstimate<Space> moved = pose();
  const PoseMatrix F = predict_pose(step, &moved);
  move(moved, F);
}

template <class Space>
UpdateReport KalmanSlam<Space>::observe(TimeNs stamp, const Observations& observations) {
  std::vector<Assignment> assignments = associator_->associate(observations, expect(observations));
  return apply(stamp, observations, std::move(assignments));
}

template <class Space>
typename KalmanSlam<Space>::Expectation KalmanSlam<Space>::expect(const Observations& /*observations*/) {
  return Expectation(*this);
}

template <class Space>
UpdateReport KalmanSlam<Space>::apply(TimeNs stamp, const Observations& observations,
                                      std::vector<Assignment> assignments) {
  UpdateReport report;
  report.assignments = std::move(assignments);
  matches_.clear();
  for (std::size_t k = 0; k < observations.size(); ++k) {
    const Assignment& assignment = report.assignments[k];
    if (assignment.verdict == Verdict::kMatched) {
      matches_.push_back({k, assignment.landmark, assignment.squared_distance});
    }
  }
  if (!matches_.empty() && !update(stamp, observations, matches_, &report)) {
    for (const Match& match : matches_) report.assignments[match.observation].verdict = Verdict::kSingular;
  }
  for (Assignment& assignment : report.assignments) {
    const bool is_index = assignment.landmark >= 0 && assignment.verdict != Verdict::kCreated;
    if (is_index) assignment.landmark = state_.info(assignment.landmark).id;
  }
  for (std::size_t k = 0; k < observations.size(); ++k) {
    Assignment& assignment = report.assignments[k];
    if (assignment.verdict != Verdict::kCreated) continue;
    if (map_fixed_) {
      assignment.verdict = Verdict::kNotInMap;
    } else if (map_size() >= options_.max_landmarks) {
      assignment.verdict = Verdict::kMapFull;
    } else {
      map_sighting(stamp, observations[k], assignment.landmark);
      assignment.landmark = state_.info(state_.landmark_count() - 1).id;
    }
  }
  if (!map_fixed_) replace_if_contradicted(stamp, observations, &report);
  return report;
}

/// The Kalman update, all matches at once: equations (4.5) to (4.9). False, and nothing changed, when S is
/// not positive definite.
template <class Space>
bool KalmanSlam<Space>::update(TimeNs stamp, const Observations& observations,
                               const std::vector<Match>& matches, UpdateReport* report) {
  const int dof = kPointDim * static_cast<int>(matches.size());
  PredictedMeasurement predicted{mean_.vector(dof), cross_.matrix(state_.size(), dof),
                                 covariance_.matrix(dof, dof)};
  predict_measurement(matches, &predicted);
  predicted.mean *= -1.0;
  for (std::size_t j = 0; j < matches.size(); ++j) {
    const int row = kPointDim * static_cast<int>(j);
    const Observation<Space>& observation = observations[matches[j].observation];
    predicted.mean.template segment<kPointDim>(row) += observation.position_in_base;  // nu
    predicted.covariance.template block<kPointDim, kPointDim>(row, row) +=            // H P H^T + R
        measurement_noise(stamp, observation, matches[j]);
  }
  if (!take_in(&predicted, false)) return false;
  for (const Match& match : matches) {
    LandmarkInfo& info = state_.info(match.landmark);
    if (map_fixed_) {
      info.last_seen = stamp;  // the next one may be an echo
    } else {
      info.add(stamp, observations[match.observation].signature);
    }
  }
  corrected(matches, predicted.covariance, predicted.cross, predicted.mean);
  report->nis = predicted.mean.squaredNorm();
  report->dof = dof;
  return true;
}

template <class Space>
bool KalmanSlam<Space>::take_in(PredictedMeasurement* innovation, bool is_absolute) {
  Eigen::Map<Eigen::MatrixXd>& S = innovation->covariance;
  Eigen::Map<Eigen::MatrixXd>& weighted = innovation->cross;  // P H^T
  Eigen::Map<Eigen::VectorXd>& whitened = innovation->mean;   // nu
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(S);  // S = L L^T, in its place
  if (!whitened.allFinite() || cholesky.info() != Eigen::Success || !is_regular(S)) return false;

  // x += K nu and P -= K S K^T, with K S K^T = (P H^T L^-T) (P H^T L^-T)^T.
  const auto L = cholesky.matrixL();
  L.solveInPlace(whitened);
  solve_on_the_right(L.transpose(), &weighted);
  Eigen::Map<Eigen::VectorXd> error = error_.vector(state_.size());  // K nu
  error.noalias() = weighted * whitened;
  if (map_fixed_) {  // Schmidt-Kalman: the map is uncertain but stands still, equation (4.10)
    state_.correct_pose(weighted);
    const auto of_pose = error.template head<kPoseDim>();
    is_absolute ? add(of_pose) : retract(of_pose);
  } else {
    is_absolute ? add_correction(weighted, error) : correct(weighted, error);
  }
  S.triangularView<Eigen::StrictlyUpper>().setZero();
  return true;
}

/// The same update by what else tells where the robot is: docs/theory.md, section 11.
template <class Space>
LocateReport KalmanSlam<Space>::locate(const PoseMeasurement<Space>& measurement, int landmark_id,
                                       double gate) {
  const int landmark = landmark_id == kNoId ? -1 : index_of(landmark_id);
  if (landmark_id != kNoId && landmark < 0) return {PositionVerdict::kUnknownBeacon};
  const Eigen::MatrixXd R = measurement.noise();
  PredictedMeasurement predicted{mean_.vector(R.rows()), cross_.matrix(state_.size(), R.rows()),
                                 covariance_.matrix(R.rows(), R.rows())};
  LocateReport report{PositionVerdict::kSingular};
  if (!predict_measurement(measurement, landmark, &predicted)) return report;
  predicted.mean *= -1.0;  // nu
  report.innovation = predicted.mean;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(predicted.covariance + R);
  if (cholesky.info() != Eigen::Success || !predicted.mean.allFinite()) return report;
  report.squared_distance = cholesky.matrixL().solve(predicted.mean).squaredNorm();
  const double log_determinant = 2.0 * Eigen::MatrixXd(cholesky.matrixL()).diagonal().array().log().sum();
  report.log_likelihood = -0.5 * (report.squared_distance + log_determinant +
                                  static_cast<double>(R.rows()) * std::log(2.0 * kPi));
  report.verdict = PositionVerdict::kOutsideGate;
  if (!(report.squared_distance < gate)) return report;
  const double doubt = options_.robust_threshold > 0.0
                           ? std::max(1.0, report.squared_distance / options_.robust_threshold)
                           : 1.0;
  predicted.covariance += doubt * R;
  report.verdict = take_in(&predicted, true) ? PositionVerdict::kUsed : PositionVerdict::kSingular;
  if (report.verdict == PositionVerdict::kUsed) {
    located(predicted.covariance, predicted.cross, predicted.mean);
  }
  return report;
}

template <class Space>
void KalmanSlam<Space>::add_landmark(int id, const Point& position_in_map, const PointMatrix& covariance) {
  LandmarkInfo info;
  info.id = id;
  ids_.take(id);
  insert_landmark(std::move(info), position_in_map, Space::PointByPose::Zero(), covariance);
}

/// P += J Sigma J^T, equation (11.10).
template <class Space>
void KalmanSlam<Space>::loosen(const PoseMatrix& covariance) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(state_.size(), kPoseDim);
  const auto move_point = [&](int row, const Point& point) {
    J.template middleRows<kPointDim>(row).template leftCols<kPointDim>().setIdentity();
    J.template middleRows<kPointDim>(row).template rightCols<Space::kTurnDim>() = Space::by_turn(point);
  };
  move_point(0, state_.map_from_base().translation());
  J.template block<Space::kTurnDim, Space::kTurnDim>(kPointDim, kPointDim).setIdentity();
  for (int i = 0; i < state_.landmark_count(); ++i) move_point(state_.row(i), state_.landmark(i));
  state_.covariance().add_product(1.0, J * covariance, J);
}

template <class Space>
void KalmanSlam<Space>::add(const Eigen::Ref<const Eigen::VectorXd>& error) {
  const typename Space::Pose& pose = state_.map_from_base();
  state_.set_map_from_base(
      Space::retract(pose, local_from_error<Space>(pose) * error.template head<kPoseDim>()));
  for (int i = 0; state_.row(i) < error.size(); ++i) {
    state_.set_landmark(i, state_.landmark(i) + error.template segment<kPointDim>(state_.row(i)));
  }
}

/// l = pose * z with its full cross-covariance, equations (4.11) and (4.12).
template <class Space>
void KalmanSlam<Space>::map_sighting(TimeNs stamp, const Observation<Space>& observation, int id) {
  const Point& z = observation.position_in_base;
  const typename Space::Pose& pose = state_.map_from_base();
  const PointMatrix by_measurement = pose.rotation();
  const typename Space::PointByPose by_pose =
      -by_measurement * Space::point_by_pose(z) * local_from_error<Space>(pose);
  LandmarkInfo info;
  info.id = id == kNoId ? ids_.next(observation.signature) : id;
  ids_.take(info.id);
  info.add(stamp, observation.signature);
  insert_landmark(std::move(info), pose * z, by_pose,
                  by_measurement * observation.covariance * by_measurement.transpose());
}

template <class Space>
void KalmanSlam<Space>::replace_if_contradicted(TimeNs stamp, const Observations& observations,
                                                UpdateReport* report) {
  const auto observations_of = [this](int id) {
    return static_cast<int>(state_.info(index_of(id)).observations);
  };
  for (const std::size_t k : contradictions_.misplaced(report->assignments, observations_of)) {
    Assignment& assignment = report->assignments[k];
    const int index = index_of(assignment.landmark);
    ids_.misplaced(state_.info(index));
    remove_landmark(index);
    map_sighting(stamp, observations[k]);
    assignment.verdict = Verdict::kCreated;
    assignment.landmark = state_.info(state_.landmark_count() - 1).id;
  }
}

template <class Space>
typename KalmanSlam<Space>::Jacobian KalmanSlam<Space>::jacobian(const Point& landmark_in_map,
                                                                 Point* point_in_base) const {
  const typename Space::Pose& pose = state_.map_from_base();
  const PredictedPoint<Space> predicted = predict_point<Space>(pose, landmark_in_map);
  if (point_in_base != nullptr) *point_in_base = predicted.point_in_base;
  return {predicted.by_pose * local_from_error<Space>(pose), predicted.by_landmark};
}

/// H_a P H_b^T of two landmarks, or of one with itself.
template <class Space>
typename Space::PointMatrix KalmanSlam<Space>::cross(const Jacobian& H_a, const Jacobian& H_b,
                                                     const PoseMatrix& pose,
                                                     const typename Space::PointByPose& a_by_pose,
                                                     const typename Space::PointByPose& b_by_pose,
                                                     const PointMatrix& a_by_b) {
  return H_a.by_pose * pose * H_b.by_pose.transpose() +
         H_a.by_landmark * a_by_pose * H_b.by_pose.transpose() +
         H_a.by_pose * b_by_pose.transpose() * H_b.by_landmark.transpose() +
         H_a.by_landmark * a_by_b * H_b.by_landmark.transpose();
}

template <class Space>
typename Space::PointMatrix KalmanSlam<Space>::measurement_noise(TimeNs stamp,
                                                                 const Observation<Space>& observation,
                                                                 const Match& match) const {
  return matched_noise<Space>(observation, state_.info(match.landmark), stamp, match.squared_distance,
                              options_.robust_threshold);
}

template <class Space>
int KalmanSlam<Space>::index_of(int id) {
  for (int i = 0; i < state_.landmark_count(); ++i) {
    if (state_.info(i).id == id) return i;
  }
  return -1;
}

template <class Space>
bool KalmanSlam<Space>::set_confirmed(int id, bool confirmed) {
  const int index = index_of(id);
  if (index >= 0) state_.info(index).confirmed = confirmed;
  return index >= 0;
}

template <class Space>
bool KalmanSlam<Space>::remove(int id) {
  const int index = index_of(id);
  if (index >= 0) remove_landmark(index);
  contradictions_.forget(id);
  return index >= 0;
}

/// The Kalman update by 0 = l_kept - l_dropped, equation (10.1).
template <class Space>
bool KalmanSlam<Space>::merge(int kept_id, int dropped_id, double gate) {
  const int kept = index_of(kept_id);
  const int dropped = index_of(dropped_id);
  if (kept < 0 || dropped < 0 || kept == dropped) return false;
  const Point innovation = state_.landmark(dropped) - state_.landmark(kept);
  Eigen::MatrixXd weighted = Eigen::MatrixXd::Zero(state_.size(), kPointDim);  // P H^T
  state_.covariance().add_weighted_columns(state_.row(kept), PointMatrix(PointMatrix::Identity()), weighted);
  state_.covariance().add_weighted_columns(state_.row(dropped), PointMatrix(-PointMatrix::Identity()),
                                           weighted);
  constexpr double kSame = 1e-6;  // m^2: how far apart the centres of one landmark's two estimates may lie
  const PointMatrix S = weighted.template middleRows<kPointDim>(state_.row(kept)) -
                        weighted.template middleRows<kPointDim>(state_.row(dropped)) +
                        kSame * PointMatrix::Identity();
  const Eigen::LLT<PointMatrix> cholesky(S);
  if (cholesky.info() != Eigen::Success) return false;
  const Point whitened = cholesky.matrixL().solve(innovation);
  if (!(whitened.squaredNorm() < gate)) return false;
  cholesky.matrixL().transpose().template solveInPlace<Eigen::OnTheRight>(weighted);
  correct(weighted, weighted * whitened);
  state_.info(kept).absorb(state_.info(dropped));
  remove_landmark(dropped);
  contradictions_.forget(dropped_id);
  return true;
}

template <class Space>
void KalmanSlam<Space>::restore(const SlamState<Space>& state) {
  state_.restore(state);
  contradictions_.clear();
  ids_.clear();
  for (const LandmarkInfo& info : state.infos) ids_.take(info.id);
}

template class KalmanSlam<Planar>;
template class KalmanSlam<Spatial>;

}  // namespace kinect_ekf_slam
