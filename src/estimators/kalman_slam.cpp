#include "kinect_ekf_slam/estimators/kalman_slam.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "kinect_ekf_slam/association/gate.h"

namespace kinect_ekf_slam {

/// The associator's view of the filter.
template <class Space>
class KalmanSlam<Space>::Expectation : public PredictedMap<Space> {
 public:
  explicit Expectation(const KalmanSlam& filter) : filter_(filter), state_(filter.state_) {}
  int size() const override { return state_.landmark_count(); }
  const LandmarkInfo& info(int landmark) const override { return state_.info(landmark); }
  Point point_in_base(int landmark) const override {
    return predict_point<Space>(state_.map_from_base(), state_.landmark(landmark)).point_in_base;
  }
  PointMatrix covariance(int landmark) const override {  // H P H^T
    return expected_covariance(filter_.jacobian(state_.landmark(landmark)), state_.pose_covariance(),
                               state_.lower().template block<kPointDim, kPoseDim>(state_.row(landmark), 0),
                               state_.landmark_covariance(landmark));
  }

 private:
  const KalmanSlam& filter_;
  const GaussianState<Space>& state_;
};

template <class Space>
void KalmanSlam<Space>::predict(const MotionStep<Space>& step) {
  PoseEstimate<Space> moved = pose();
  const PoseMatrix F = predict_pose(step, &moved);
  move(moved, F);
}

template <class Space>
UpdateReport KalmanSlam<Space>::observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) {
  UpdateReport report;
  report.assignments = associator_->associate(observations, Expectation(*this));

  std::vector<Match> matches;
  std::vector<std::size_t> unmapped;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    Assignment& assignment = report.assignments[k];
    if (assignment.verdict == Verdict::kMatched) {
      matches.push_back({k, assignment.landmark, assignment.squared_distance});
    } else if (assignment.verdict == Verdict::kCreated) {
      unmapped.push_back(k);
    }
  }
  if (!matches.empty() && !update(stamp, observations, matches, &report)) {
    for (const Match& match : matches) report.assignments[match.observation].verdict = Verdict::kSingular;
  }
  for (Assignment& assignment : report.assignments) {
    if (assignment.landmark >= 0) assignment.landmark = state_.info(assignment.landmark).id;
  }
  for (const std::size_t k : unmapped) {
    Assignment& assignment = report.assignments[k];
    if (map_fixed_) {
      assignment.verdict = Verdict::kNotInMap;
    } else if (map_size() >= options_.max_landmarks) {
      assignment.verdict = Verdict::kMapFull;
    } else {
      add_landmark(stamp, observations[k]);
      assignment.landmark = state_.info(state_.landmark_count() - 1).id;
    }
  }
  if (!map_fixed_) replace_if_contradicted(stamp, observations, &report);
  return report;
}

/// The Kalman update, all matches at once: equations (4.5) to (4.9). False, and nothing changed, when S is
/// not positive definite.
template <class Space>
bool KalmanSlam<Space>::update(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                               const std::vector<Match>& matches, UpdateReport* report) {
  predict_measurement(matches, &predicted_);
  Eigen::VectorXd innovation = -predicted_.mean;  // nu
  Eigen::MatrixXd& S = predicted_.covariance;     // H P H^T + R
  Eigen::MatrixXd& weighted = predicted_.cross;   // P H^T
  for (std::size_t j = 0; j < matches.size(); ++j) {
    const int row = kPointDim * static_cast<int>(j);
    const Observation<Space>& observation = observations[matches[j].observation];
    innovation.segment<kPointDim>(row) += observation.position_in_base;
    S.block<kPointDim, kPointDim>(row, row) += measurement_noise(stamp, observation, matches[j]);
  }
  const Eigen::LLT<Eigen::MatrixXd> cholesky(S);  // S = L L^T
  if (!innovation.allFinite() || cholesky.info() != Eigen::Success || !(cholesky.rcond() > kLeastRcond))
    return false;

  // x += K nu and P -= K S K^T, with K S K^T = (P H^T L^-T) (P H^T L^-T)^T.
  const auto L = cholesky.matrixL();
  const Eigen::VectorXd whitened = L.solve(innovation);
  L.transpose().template solveInPlace<Eigen::OnTheRight>(weighted);
  auto P = state_.lower();
  if (map_fixed_) {  // Schmidt-Kalman: the map is uncertain but stands still, equation (4.10)
    const auto pose_rows = weighted.topRows<kPoseDim>();
    const auto landmark_rows = weighted.bottomRows(state_.size() - kPoseDim);
    P.template topLeftCorner<kPoseDim, kPoseDim>().noalias() -= pose_rows * pose_rows.transpose();
    P.bottomLeftCorner(landmark_rows.rows(), kPoseDim).noalias() -= landmark_rows * pose_rows.transpose();
    retract(pose_rows * whitened);
    for (const Match& match : matches)
      state_.info(match.landmark).last_seen = stamp;  // the next one may be an echo
  } else {
    P.template selfadjointView<Eigen::Lower>().rankUpdate(weighted, -1.0);
    retract(weighted * whitened);
    for (const Match& match : matches)
      state_.info(match.landmark).add(stamp, observations[match.observation].signature);
  }
  corrected(matches, cholesky, weighted, whitened);
  report->nis = whitened.squaredNorm();
  report->dof = static_cast<int>(innovation.size());
  return true;
}

template <class Space>
void KalmanSlam<Space>::retract(const Eigen::Ref<const Eigen::VectorXd>& error) {
  const typename Space::Pose& pose = state_.map_from_base();
  state_.set_map_from_base(
      Space::retract(pose, local_from_error<Space>(pose) * error.template head<kPoseDim>()));
  for (int i = 0; state_.row(i) < error.size(); ++i) {
    state_.set_landmark(i, state_.landmark(i) + error.template segment<kPointDim>(state_.row(i)));
  }
}

/// l = pose * z with its full cross-covariance, equations (4.11) and (4.12).
template <class Space>
void KalmanSlam<Space>::add_landmark(TimeNs stamp, const Observation<Space>& observation) {
  const Point& z = observation.position_in_base;
  const typename Space::Pose& pose = state_.map_from_base();
  const PointMatrix by_measurement = pose.rotation();
  const typename Space::PointByPose by_pose =
      -by_measurement * Space::point_by_pose(z) * local_from_error<Space>(pose);
  LandmarkInfo info;
  info.id = ids_.next(observation.signature);
  info.add(stamp, observation.signature);
  insert_landmark(std::move(info), pose * z, by_pose,
                  by_measurement * observation.covariance * by_measurement.transpose());
}

template <class Space>
int KalmanSlam<Space>::index_of(int id) const {
  int index = 0;
  while (state_.info(index).id != id) ++index;
  return index;
}

template <class Space>
void KalmanSlam<Space>::replace_if_contradicted(TimeNs stamp,
                                                const std::vector<Observation<Space>>& observations,
                                                UpdateReport* report) {
  const auto observations_of = [this](int id) {
    return static_cast<int>(state_.info(index_of(id)).observations);
  };
  for (const std::size_t k : contradictions_.misplaced(report->assignments, observations_of)) {
    Assignment& assignment = report->assignments[k];
    const int index = index_of(assignment.landmark);
    ids_.misplaced(state_.info(index));
    remove_landmark(index);
    add_landmark(stamp, observations[k]);
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

template <class Space>
typename Space::PointMatrix KalmanSlam<Space>::expected_covariance(
    const Jacobian& H, const PoseMatrix& pose, const typename Space::PointByPose& landmark_by_pose,
    const PointMatrix& landmark) {
  const PointMatrix mixed = H.by_landmark * landmark_by_pose * H.by_pose.transpose();
  return H.by_pose * pose * H.by_pose.transpose() + mixed + mixed.transpose() +
         H.by_landmark * landmark * H.by_landmark.transpose();
}

template <class Space>
typename Space::PointMatrix KalmanSlam<Space>::measurement_noise(TimeNs stamp,
                                                                 const Observation<Space>& observation,
                                                                 const Match& match) const {
  return matched_noise<Space>(observation, state_.info(match.landmark), stamp, match.squared_distance,
                              options_.robust_threshold);
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
