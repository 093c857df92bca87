#include "kinect_ekf_slam/estimators/compressed_ekf.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "kinect_ekf_slam/association/gate.h"

namespace kinect_ekf_slam {

template <class Space>
CompressedEkf<Space>::CompressedEkf(const EstimatorOptions& options,
                                    std::shared_ptr<const Associator<Space>> associator,
                                    const PoseEstimate<Space>& initial)
    : Base(options, std::move(associator), initial), whole_(state_) {
  activate({});
}

template <class Space>
typename CompressedEkf<Space>::Expectation CompressedEkf<Space>::expect(const Observations& observations) {
  pending_.advance(&whole_.covariance());
  if (!observations.empty()) {
    const Point travelled = state_.map_from_base().translation() - centre_;
    if (travelled.norm() > options_.active_hysteresis * options_.active_radius) {
      change_region({});
    }
    std::set<int> found = concerned(observations);
    if (!found.empty()) {
      found.insert(active_.begin(), active_.end());
      change_region(found);
    }
  }
  return Base::expect(observations);
}

template <class Space>
int CompressedEkf<Space>::index_of(int id) {
  for (int i = 0; i < whole_.landmark_count(); ++i) {
    if (whole_.info(i).id != id || std::binary_search(active_.begin(), active_.end(), i)) continue;
    std::set<int> found(active_.begin(), active_.end());
    found.insert(i);
    change_region(found);
  }
  return Base::index_of(id);
}

template <class Space>
template <class Change>
void CompressedEkf<Space>::change_whole(const Change& change) {
  finish_whole();
  std::vector<int> all(static_cast<std::size_t>(whole_.landmark_count()));
  std::iota(all.begin(), all.end(), 0);
  activate(std::move(all));
  change();
  start_anew();
}

template <class Space>
bool CompressedEkf<Space>::merge(int kept_id, int dropped_id, double gate) {
  bool merged = false;
  change_whole([&] { merged = Base::merge(kept_id, dropped_id, gate); });
  return merged;
}

template <class Space>
void CompressedEkf<Space>::loosen(const typename Space::PoseMatrix& covariance) {
  change_whole([&] { Base::loosen(covariance); });
}

template <class Space>
void CompressedEkf<Space>::finish_whole() {
  update_whole();
  pending_.finish(&whole_.covariance());
}

template <class Space>
void CompressedEkf<Space>::change_region(const std::set<int>& others) {
  update_whole();
  activate(choose_active(others));
  ++region_changes_;
}

template <class Space>
std::vector<int> CompressedEkf<Space>::choose_active(const std::set<int>& others) const {
  const Point robot = whole_.map_from_base().translation();
  std::vector<int> landmarks;
  for (int i = 0; i < whole_.landmark_count(); ++i) {
    const bool is_near = (whole_.landmark(i) - robot).norm() < options_.active_radius;
    if (is_near || is_beacon(whole_.info(i).id) || others.count(i) > 0) landmarks.push_back(i);
  }
  return landmarks;
}

template <class Space>
void CompressedEkf<Space>::activate(std::vector<int> landmarks) {
  active_ = std::move(landmarks);
  Eigen::MatrixXd columns = whole_.columns(active_);
  pending_.correct_columns(whole_.covariance(), active_, &columns);
  state_ = whole_.marginal(active_, columns);
  deferred_.start(whole_.landmark_count(), active_, std::move(columns));

  centre_ = whole_.map_from_base().translation();
  passive_.clear();
  passive_of_identity_.clear();
  largest_sigma_ = 0.0;
  for (int i = 0; i < whole_.landmark_count(); ++i) {
    if (std::binary_search(active_.begin(), active_.end(), i)) continue;
    passive_.push_back({(whole_.landmark(i) - centre_).norm(), i});
    passive_of_identity_[whole_.info(i).source_id].push_back(i);
    largest_sigma_ = std::max(largest_sigma_, std::sqrt(whole_.landmark_covariance(i).trace()));
  }
  std::sort(passive_.begin(), passive_.end());
}

template <class Space>
std::set<int> CompressedEkf<Space>::concerned(const std::vector<Observation<Space>>& observations) const {
  std::set<int> landmarks;
  if (passive_.empty()) return landmarks;
  for (const Observation<Space>& observation : observations) {
    if (!associator_->knows_identities()) {
      add_concerned(observation, &landmarks);
      continue;
    }
    const auto named = passive_of_identity_.find(observation.signature.source_id);
    if (named != passive_of_identity_.end()) landmarks.insert(named->second.begin(), named->second.end());
  }
  return landmarks;
}

/// Those that may lie within the associator's reach. A bound on the innovation's standard deviation, equation
/// (9.11), leaves the nearest few; of these the covariance (9.10), never too small, tells.
template <class Space>
void CompressedEkf<Space>::add_concerned(const Observation<Space>& observation,
                                         std::set<int>* landmarks) const {
  const AssociationReach reach = associator_->reach();
  const typename Space::Pose& pose = state_.map_from_base();
  const PoseMatrix P = state_.pose_covariance();
  const Point& z = observation.position_in_base;
  const double gate = std::sqrt(reach.squared_mahalanobis);
  const double position_sigma = std::sqrt(P.template topLeftCorner<kPointDim, kPointDim>().trace());
  const double turn_sigma =
      std::sqrt(P.template bottomRightCorner<Space::kTurnDim, Space::kTurnDim>().trace());
  const double sigma =
      position_sigma + z.norm() * turn_sigma + largest_sigma_ + std::sqrt(observation.covariance.trace());
  const double largest_innovation = gate * turn_sigma < 1.0
                                        ? std::max(gate * sigma / (1.0 - gate * turn_sigma), reach.distance)
                                        : std::numeric_limits<double>::infinity();
  const double farthest =
      (pose * z - centre_).norm() + largest_innovation + largest_sigma_ * deferred_.largest_shift();
  for (const Passive& passive : passive_) {
    if (passive.distance > farthest) break;
    Point expected;
    const auto H = this->jacobian(deferred_.landmark(whole_, passive.landmark), &expected);
    const auto by_pose = deferred_.landmark_by_pose(passive.landmark);
    const PointMatrix S =
        Base::cross(H, H, P, by_pose, by_pose, whole_.landmark_covariance(passive.landmark)) +
        observation.covariance;
    const Point innovation = z - expected;
    const auto distance = squared_mahalanobis<kPointDim>(innovation, S);
    const bool is_apart =
        distance && *distance >= reach.squared_mahalanobis && innovation.norm() >= reach.distance;
    if (!is_apart) landmarks->insert(passive.landmark);
  }
}

template <class Space>
void CompressedEkf<Space>::move(const PoseEstimate<Space>& moved, const PoseMatrix& F) {
  Base::move(moved, F);
  deferred_.move(F);
}

template <class Space>
void CompressedEkf<Space>::insert_landmark(LandmarkInfo info, const Point& landmark_in_map,
                                           const typename Space::PointByPose& by_pose,
                                           const PointMatrix& independent) {
  active_.push_back(map_size());
  deferred_.add_landmark(by_pose);
  Base::insert_landmark(std::move(info), landmark_in_map, by_pose, independent);
}

template <class Space>
void CompressedEkf<Space>::remove_landmark(int index) {
  finish_whole();
  whole_.remove_landmark(active_[index]);
  std::vector<int> rest = active_;
  rest.erase(rest.begin() + index);
  for (auto later = rest.begin() + index; later != rest.end(); ++later) --*later;
  activate(std::move(rest));
}

template <class Space>
void CompressedEkf<Space>::corrected(const std::vector<Match>& matches,
                                     const Eigen::Ref<const Eigen::MatrixXd>& L,
                                     const Eigen::Ref<const Eigen::MatrixXd>& weighted,
                                     const Eigen::Ref<const Eigen::VectorXd>& whitened) {
  if (passive_.empty()) return;
  const Eigen::MatrixXd& phi = deferred_.phi();
  Eigen::Map<Eigen::MatrixXd> L_H_phi = L_H_phi_.matrix(whitened.size(), phi.cols());  // L^-1 H phi
  for (std::size_t j = 0; j < matches.size(); ++j) {
    L_H_phi.middleRows<kPointDim>(kPointDim * j).noalias() =
        H_[j].by_pose * phi.topRows<kPoseDim>() +
        H_[j].by_landmark * phi.middleRows<kPointDim>(state_.row(matches[j].landmark));
  }
  L.template triangularView<Eigen::Lower>().solveInPlace(L_H_phi);
  deferred_.correct(weighted, whitened, L_H_phi, map_fixed_);
}

template <class Space>
void CompressedEkf<Space>::located(const Eigen::Ref<const Eigen::MatrixXd>& L,
                                   const Eigen::Ref<const Eigen::MatrixXd>& weighted,
                                   const Eigen::Ref<const Eigen::VectorXd>& whitened) {
  if (passive_.empty()) return;
  const Eigen::MatrixXd& phi = deferred_.phi();
  Eigen::Map<Eigen::MatrixXd> L_H_phi = L_H_phi_.matrix(whitened.size(), phi.cols());  // L^-1 H phi
  L_H_phi.noalias() = located_.by_pose * phi.topRows<kPoseDim>();
  if (located_.landmark >= 0) {
    L_H_phi.noalias() += located_.by_landmark * phi.middleRows<kPointDim>(state_.row(located_.landmark));
  }
  L.template triangularView<Eigen::Lower>().solveInPlace(L_H_phi);
  deferred_.correct(weighted, whitened, L_H_phi, map_fixed_);
}

template <class Space>
std::vector<LandmarkEstimate<Space>> CompressedEkf<Space>::landmarks() const {
  std::vector<LandmarkEstimate<Space>> estimates(map_size());
  for (const Passive& passive : passive_) {
    const int i = passive.landmark;
    PointMatrix covariance = whole_.landmark_covariance(i);
    pending_.correct_covariance(whole_.covariance(), i, &covariance);
    estimates[i] = {whole_.info(i), deferred_.landmark(whole_, i),
                    deferred_.landmark_covariance(covariance, i)};
  }
  for (int j = 0; j < state_.landmark_count(); ++j) {
    estimates[active_[j]] = {state_.info(j), state_.landmark(j), state_.landmark_covariance(j)};
  }
  return estimates;
}

template <class Space>
SlamState<Space> CompressedEkf<Space>::snapshot() const {
  GaussianState<Space> whole = whole_;
  PendingUpdates<Space> pending = pending_;
  deferred_.apply(active_, state_, &whole, &pending);
  pending.finish(&whole.covariance());
  return whole.snapshot();
}

template <class Space>
void CompressedEkf<Space>::restore(const SlamState<Space>& state) {
  Base::restore(state);
  start_anew();
}

template <class Space>
void CompressedEkf<Space>::start_anew() {
  whole_ = std::move(state_);
  pending_.clear();
  activate(choose_active({}));
}

template <class Space>
void CompressedEkf<Space>::set_pose(const PoseEstimate<Space>& pose) {
  Base::set_pose(pose);
  deferred_.set_pose();
}

/// What was learnt so far is told to the whole map first: from then on it is not touched by rounding either.
template <class Space>
void CompressedEkf<Space>::set_map_fixed(bool fixed) {
  if (fixed && !map_fixed_) {
    finish_whole();
    activate(active_);
  }
  Base::set_map_fixed(fixed);
}

template class CompressedEkf<Planar>;
template class CompressedEkf<Spatial>;

}  // namespace kinect_ekf_slam
