#include "kinect_ekf_slam/estimators/ekf.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>
#include <utility>

#include "kinect_ekf_slam/association/gate.h"

namespace kinect_ekf_slam {
namespace {

/// columns += P.middleCols(start, weights.rows()) * weights, P symmetric and stored in its lower triangle.
template <class Weights>
void add_weighted_columns(const Eigen::Ref<const Eigen::MatrixXd>& lower, int start, const Weights& weights,
                          Eigen::Ref<Eigen::MatrixXd> columns) {
  const auto count = weights.rows();
  const auto below = lower.rows() - start - count;
  columns.topRows(start).noalias() += lower.block(start, 0, count, start).transpose() * weights;
  columns.middleRows(start, count).noalias() +=
      lower.block(start, start, count, count).template selfadjointView<Eigen::Lower>() * weights;
  columns.bottomRows(below).noalias() += lower.block(start + count, start, below, count) * weights;
}

}  // namespace

/// The associator's view of the filter.
template <class Space>
class Ekf<Space>::Prediction : public PredictedMap<Space> {
 public:
  explicit Prediction(const Ekf& ekf) : ekf_(ekf) {}
  int size() const override { return ekf_.landmark_count(); }
  const LandmarkInfo& info(int landmark) const override { return ekf_.infos_[landmark]; }
  Point point_in_base(int landmark) const override {
    return predict_point<Space>(ekf_.pose_, ekf_.landmark(landmark)).point_in_base;
  }
  PointMatrix covariance(int landmark) const override {
    return ekf_.predicted_covariance(landmark, ekf_.jacobian(landmark, nullptr));
  }

 private:
  const Ekf& ekf_;
};

template <class Space>
Ekf<Space>::Ekf(const EstimatorOptions& options, std::shared_ptr<const Associator<Space>> associator,
                const PoseEstimate<Space>& initial)
    : options_(options),
      associator_(std::move(associator)),
      covariance_(kPoseDim, kPoseDim),
      ids_(associator_->knows_identities()) {
  set_pose(initial);
}

template <class Space>
void Ekf<Space>::predict(const MotionStep<Space>& step) {
  PoseEstimate<Space> moved = pose();
  const PoseMatrix F = predict_pose(step, &moved);
  pose_ = moved.map_from_base;

  // Only the pose's rows and columns of P change; the landmarks stand still.
  auto P = covariance();
  P.template topLeftCorner<kPoseDim, kPoseDim>() = moved.covariance;
  auto landmark_rows = P.bottomLeftCorner(state_size() - kPoseDim, kPoseDim);
  for (int i = 0; i < landmark_rows.rows(); ++i) {
    landmark_rows.row(i) = (landmark_rows.row(i) * F.transpose()).eval();
  }
}

template <class Space>
UpdateReport Ekf<Space>::observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) {
  UpdateReport report;
  report.assignments = associator_->associate(observations, Prediction(*this));

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
    if (assignment.landmark >= 0) assignment.landmark = infos_[assignment.landmark].id;
  }
  for (const std::size_t k : unmapped) {
    Assignment& assignment = report.assignments[k];
    if (map_fixed_) {
      assignment.verdict = Verdict::kNotInMap;
    } else if (landmark_count() >= options_.max_landmarks) {
      assignment.verdict = Verdict::kMapFull;
    } else {
      add_landmark(stamp, observations[k]);
      assignment.landmark = infos_.back().id;
    }
  }
  if (!map_fixed_ && options_.replace_after > 0) replace_if_contradicted(stamp, observations, &report);
  return report;
}

/// The Kalman update, all matches at once: equations (4.5) to (4.9). False, and nothing changed, when S is
/// not positive definite.
template <class Space>
bool Ekf<Space>::update(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                        const std::vector<Match>& matches, UpdateReport* report) {
  const int rows = kPointDim * static_cast<int>(matches.size());
  auto P = covariance();
  std::vector<Jacobian> H(matches.size());
  Eigen::VectorXd innovation(rows);
  cross_.setZero(state_size(), rows);  // P H^T
  for (std::size_t j = 0; j < matches.size(); ++j) {
    const Match& match = matches[j];
    Point expected;
    H[j] = jacobian(match.landmark, &expected);
    innovation.segment<kPointDim>(kPointDim * j) =
        observations[match.observation].position_in_base - expected;
    auto columns = cross_.middleCols(kPointDim * j, kPointDim);
    add_weighted_columns(P, 0, H[j].by_pose.transpose(), columns);
    add_weighted_columns(P, row(match.landmark), H[j].by_landmark.transpose(), columns);
  }
  Eigen::MatrixXd S(rows, rows);  // H P H^T + R
  for (std::size_t j = 0; j < matches.size(); ++j) {
    S.middleRows<kPointDim>(kPointDim * j) =
        H[j].by_pose * cross_.topRows<kPoseDim>() +
        H[j].by_landmark * cross_.middleRows<kPointDim>(row(matches[j].landmark));
    S.block<kPointDim, kPointDim>(kPointDim * j, kPointDim * j) +=
        measurement_noise(stamp, observations[matches[j].observation], matches[j]);
  }
  const Eigen::LLT<Eigen::MatrixXd> cholesky(S);  // S = L L^T
  if (!innovation.allFinite() || cholesky.info() != Eigen::Success || !(cholesky.rcond() > kLeastRcond))
    return false;

  // x += K nu and P -= K S K^T, with K S K^T = (P H^T L^-T) (P H^T L^-T)^T.
  const auto L = cholesky.matrixL();
  const Eigen::VectorXd whitened = L.solve(innovation);
  L.transpose().solveInPlace<Eigen::OnTheRight>(cross_);
  if (map_fixed_) {  // Schmidt-Kalman: the map is uncertain but stands still, equation (4.10)
    const auto pose_rows = cross_.topRows<kPoseDim>();
    const auto landmark_rows = cross_.bottomRows(state_size() - kPoseDim);
    retract(pose_rows * whitened);
    P.template topLeftCorner<kPoseDim, kPoseDim>().noalias() -= pose_rows * pose_rows.transpose();
    P.bottomLeftCorner(landmark_rows.rows(), kPoseDim).noalias() -= landmark_rows * pose_rows.transpose();
    for (const Match& match : matches)
      infos_[match.landmark].last_seen = stamp;  // the next one may be an echo
  } else {
    retract(cross_ * whitened);
    P.template selfadjointView<Eigen::Lower>().rankUpdate(cross_, -1.0);
    for (const Match& match : matches) {
      infos_[match.landmark].add(stamp, observations[match.observation].signature);
      contradictions_[match.landmark] = 0;
    }
  }
  report->nis = whitened.squaredNorm();
  report->dof = rows;
  return true;
}

/// Moves the state by an error: the whole of it, or the pose alone when that is all that is given.
template <class Space>
void Ekf<Space>::retract(const Eigen::Ref<const Eigen::VectorXd>& error) {
  const typename Space::PoseVector local = local_from_error<Space>(pose_) * error.head<kPoseDim>();
  pose_ = Space::retract(pose_, local);
  const auto moved = error.size() - kPoseDim;
  landmarks_.head(moved) += error.tail(moved);
}

/// l = pose * z with its full cross-covariance, equations (4.11) and (4.12).
template <class Space>
void Ekf<Space>::add_landmark(TimeNs stamp, const Observation<Space>& observation) {
  const Point& z = observation.position_in_base;
  const PointMatrix by_measurement = pose_.rotation();
  const Eigen::Matrix<double, kPointDim, kPoseDim> by_pose =
      -by_measurement * Space::point_by_pose(z) * local_from_error<Space>(pose_);

  const int old_size = state_size();
  const int new_size = old_size + kPointDim;
  if (covariance_.rows() < new_size) {
    const int capacity = std::max(2 * old_size, 64);
    covariance_.conservativeResize(capacity, capacity);
  }
  LandmarkInfo info;
  info.id = ids_.next(observation.signature);
  info.add(stamp, observation.signature);
  infos_.push_back(std::move(info));
  contradictions_.push_back(0);
  landmarks_.conservativeResize(landmarks_.size() + kPointDim);
  landmarks_.tail<kPointDim>() = pose_ * z;

  auto P = covariance();
  auto cross = P.block(old_size, 0, kPointDim, old_size);
  cross.template leftCols<kPoseDim>() = by_pose * pose_covariance();
  cross.rightCols(old_size - kPoseDim) =
      by_pose * P.block(kPoseDim, 0, old_size - kPoseDim, kPoseDim).transpose();
  P.template bottomRightCorner<kPointDim, kPointDim>() =
      cross.template leftCols<kPoseDim>() * by_pose.transpose() +
      by_measurement * observation.covariance * by_measurement.transpose();
}

/// Forgets a landmark: what it said of the others stays with them.
template <class Space>
void Ekf<Space>::remove_landmark(int index) {
  SlamState<Space> state = snapshot();
  const int first = row(index);
  const int after = static_cast<int>(state.covariance.rows()) - first - kPointDim;
  const auto shift = [&](auto& matrix, int start) {  // rows up, over the landmark's
    matrix.middleRows(start, after) = matrix.middleRows(start + kPointDim, after).eval();
    matrix.conservativeResize(matrix.rows() - kPointDim, matrix.cols());
  };
  shift(state.landmarks_in_map, first - kPoseDim);
  shift(state.covariance, first);
  state.covariance.transposeInPlace();
  shift(state.covariance, first);
  state.infos.erase(state.infos.begin() + index);
  std::vector<int> contradictions = std::move(contradictions_);
  contradictions.erase(contradictions.begin() + index);
  LandmarkIds ids = ids_;
  ids.misplaced(infos_[index]);
  restore(state);
  contradictions_ = std::move(contradictions);
  ids_ = std::move(ids);
}

template <class Space>
void Ekf<Space>::replace_if_contradicted(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                                         UpdateReport* report) {
  std::set<int> settled;  // a message counts once for a landmark, and not against one that it matched as well
  for (const Assignment& assignment : report->assignments) {
    if (assignment.verdict == Verdict::kMatched) settled.insert(assignment.landmark);
  }
  for (std::size_t k = 0; k < observations.size(); ++k) {
    Assignment& assignment = report->assignments[k];
    if (assignment.verdict != Verdict::kOutsideGate || !settled.insert(assignment.landmark).second) continue;
    const auto info = std::find_if(infos_.begin(), infos_.end(), [&](const LandmarkInfo& candidate) {
      return candidate.id == assignment.landmark;
    });
    if (info == infos_.end()) continue;
    const int index = static_cast<int>(info - infos_.begin());
    const int contradictions = ++contradictions_[index];
    if (contradictions < options_.replace_after || contradictions < static_cast<int>(info->observations)) {
      continue;
    }
    remove_landmark(index);
    add_landmark(stamp, observations[k]);
    assignment.verdict = Verdict::kCreated;
    assignment.landmark = infos_.back().id;
  }
}

template <class Space>
typename Space::PoseMatrix Ekf<Space>::pose_covariance() const {
  return covariance_.topLeftCorner<kPoseDim, kPoseDim>().template selfadjointView<Eigen::Lower>();
}

template <class Space>
typename Space::PointMatrix Ekf<Space>::landmark_covariance(int index) const {
  return covariance_.block<kPointDim, kPointDim>(row(index), row(index))
      .template selfadjointView<Eigen::Lower>();
}

template <class Space>
typename Ekf<Space>::Jacobian Ekf<Space>::jacobian(int index, Point* point_in_base) const {
  const PredictedPoint<Space> predicted = predict_point<Space>(pose_, landmark(index));
  if (point_in_base != nullptr) *point_in_base = predicted.point_in_base;
  return {predicted.by_pose * local_from_error<Space>(pose_), predicted.by_landmark};
}

template <class Space>
typename Space::PointMatrix Ekf<Space>::measurement_noise(TimeNs stamp, const Observation<Space>& observation,
                                                          const Match& match) const {
  const LandmarkInfo& info = infos_[match.landmark];
  const double echo = info.last_seen == 0 ? 1.0
                                          : correlation_inflation(to_seconds(stamp - info.last_seen),
                                                                  observation.correlation_time);
  const double doubt = options_.robust_threshold > 0.0
                           ? std::max(1.0, match.squared_distance / options_.robust_threshold)
                           : 1.0;
  return std::max(echo, doubt) * observation.covariance;
}

template <class Space>
typename Space::PointMatrix Ekf<Space>::predicted_covariance(int index, const Jacobian& H) const {
  const auto landmark_by_pose = covariance_.block<kPointDim, kPoseDim>(row(index), 0);
  const PointMatrix mixed = H.by_landmark * landmark_by_pose * H.by_pose.transpose();
  return H.by_pose * pose_covariance() * H.by_pose.transpose() + mixed + mixed.transpose() +
         H.by_landmark * landmark_covariance(index) * H.by_landmark.transpose();
}

template <class Space>
PoseEstimate<Space> Ekf<Space>::pose() const {
  return {pose_, pose_covariance()};
}

template <class Space>
std::vector<LandmarkEstimate<Space>> Ekf<Space>::landmarks() const {
  std::vector<LandmarkEstimate<Space>> estimates;
  estimates.reserve(infos_.size());
  for (int i = 0; i < landmark_count(); ++i) {
    estimates.push_back({infos_[i], landmark(i), landmark_covariance(i)});
  }
  return estimates;
}

template <class Space>
SlamState<Space> Ekf<Space>::snapshot() const {
  const auto stored = covariance_.topLeftCorner(state_size(), state_size());
  return {pose_, infos_, landmarks_, stored.template selfadjointView<Eigen::Lower>()};
}

template <class Space>
void Ekf<Space>::restore(const SlamState<Space>& state) {
  pose_ = state.map_from_base;
  landmarks_ = state.landmarks_in_map;
  covariance_ = state.covariance;
  infos_ = state.infos;
  contradictions_.assign(infos_.size(), 0);
  ids_.clear();
  for (const LandmarkInfo& info : infos_) ids_.take(info.id);
}

template <class Space>
void Ekf<Space>::set_pose(const PoseEstimate<Space>& pose) {
  pose_ = pose.map_from_base;
  auto P = covariance();
  P.leftCols(kPoseDim).setZero();
  P.template topLeftCorner<kPoseDim, kPoseDim>() = pose.covariance;
}

template class Ekf<Planar>;

}  // namespace kinect_ekf_slam
