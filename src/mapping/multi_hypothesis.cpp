#include "kinect_ekf_slam/mapping/multi_hypothesis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "kinect_ekf_slam/association/gate.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kSame = 0.1;  // squared Mahalanobis distance below which two estimates do not differ

}  // namespace

template <class Space>
bool MultiHypothesis<Space>::Decision::operator==(const Decision& other) const {
  const auto key = [](const Decision& decision) {
    const bool accepted = is_accepted(decision.assignment.verdict);
    return std::make_tuple(decision.stamp, decision.detection, accepted,
                           accepted ? decision.assignment.landmark : kNoId);
  };
  return key(*this) == key(other);
}

template <class Space>
typename MultiHypothesis<Space>::Hypothesis MultiHypothesis<Space>::Hypothesis::copy() const {
  return {std::make_unique<ManagedMap<Space>>(*map), log_weight, decisions, provisional_weight};
}

template <class Space>
MultiHypothesis<Space>::MultiHypothesis(const ManagedMap<Space>& map, const AssociationOptions& options)
    : options_(options), ranking_(options) {
  hypotheses_.emplace_back();
  hypotheses_.back().map = std::make_unique<ManagedMap<Space>>(map);
  for (const auto& landmark : map.landmarks()) unused_id_ = std::max(unused_id_, landmark.info.id + 1);
}

template <class Space>
MultiHypothesis<Space>::MultiHypothesis(const MultiHypothesis& other)
    : SlamEstimator<Space>(other),
      options_(other.options_),
      ranking_(other.ranking_),
      told_(other.told_),
      ids_of_frame_(other.ids_of_frame_),
      unused_id_(other.unused_id_) {
  for (const Hypothesis& hypothesis : other.hypotheses_) hypotheses_.push_back(hypothesis.copy());
}

template <class Space>
void MultiHypothesis<Space>::predict(const MotionStep<Space>& step) {
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.map->predict(step);
}

template <class Space>
UpdateReport MultiHypothesis<Space>::observe(TimeNs stamp, const Observations& observations) {
  ids_of_frame_.clear();
  const std::vector<Branch> branches = branch(observations);
  std::vector<std::size_t> children(hypotheses_.size(), 0);
  for (const Branch& branch : branches) ++children[branch.parent];

  std::vector<Hypothesis> followed;
  std::vector<UpdateReport> reports;
  for (const Branch& branch : branches) {
    Hypothesis& parent = hypotheses_[branch.parent];
    followed.push_back(--children[branch.parent] > 0 ? parent.copy() : std::move(parent));
    reports.push_back(follow(stamp, observations, branch.ranked, &followed.back()));
  }
  hypotheses_ = std::move(followed);
  // Sorted again: a landmark that was forgotten took its weight along.
  std::size_t likeliest = 0;
  for (std::size_t i = 1; i < hypotheses_.size(); ++i) {
    if (hypotheses_[i].log_weight > hypotheses_[likeliest].log_weight) likeliest = i;
  }
  std::swap(hypotheses_[0], hypotheses_[likeliest]);
  UpdateReport report = std::move(reports[likeliest]);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    told_.push_back({stamp, observations[k].detection, report.assignments[k]});
  }
  drop_the_same();
  decide(stamp);
  tell_revisions(stamp, &report);
  return report;
}

template <class Space>
LocateReport MultiHypothesis<Space>::locate(const PoseMeasurement<Space>& measurement, int landmark_id,
                                            double gate) {
  LocateReport report = hypotheses_.front().map->locate(measurement, landmark_id, gate);
  if (report.verdict != PositionVerdict::kUsed) return report;
  for (std::size_t i = 1; i < hypotheses_.size(); ++i) {
    const LocateReport other =
        hypotheses_[i].map->locate(measurement, landmark_id, std::numeric_limits<double>::infinity());
    if (other.verdict != PositionVerdict::kUsed) continue;
    hypotheses_[i].log_weight += other.log_likelihood - report.log_likelihood;
  }
  return report;
}

template <class Space>
void MultiHypothesis<Space>::add_landmark(int id, const typename Space::Point& position_in_map,
                                          const typename Space::PointMatrix& covariance) {
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.map->add_landmark(id, position_in_map, covariance);
}

template <class Space>
void MultiHypothesis<Space>::loosen(const typename Space::PoseMatrix& covariance) {
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.map->loosen(covariance);
}

/// All likely continuations of all hypotheses, the likeliest first.
template <class Space>
std::vector<typename MultiHypothesis<Space>::Branch> MultiHypothesis<Space>::branch(
    const Observations& observations) {
  std::vector<Branch> branches;
  for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
    Hypothesis& hypothesis = hypotheses_[i];
    for (RankedAssignment& ranked :
         ranking_.rank(observations, hypothesis.map->expect(observations), !hypothesis.map->map_fixed())) {
      const double log_weight = hypothesis.log_weight + ranked.log_ratio;
      branches.push_back({i, std::move(ranked), log_weight});
    }
  }
  std::stable_sort(branches.begin(), branches.end(), [](const Branch& left, const Branch& right) {
    return left.log_weight > right.log_weight;
  });
  const double least = branches.front().log_weight - options_.prune_width;
  while (branches.back().log_weight < least ||
         branches.size() > static_cast<std::size_t>(options_.max_hypotheses)) {
    branches.pop_back();
  }
  const double largest = branches.front().log_weight;  // weights are relative: they stay near zero
  for (Branch& branch : branches) branch.log_weight -= largest;
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.log_weight -= largest;
  return branches;
}

template <class Space>
UpdateReport MultiHypothesis<Space>::follow(TimeNs stamp, const Observations& observations,
                                            const RankedAssignment& ranked, Hypothesis* hypothesis) {
  std::vector<Assignment> assignments = ranked.assignments;
  for (std::size_t k = 0; k < assignments.size(); ++k) {
    if (assignments[k].verdict == Verdict::kCreated) assignments[k].landmark = new_id(k);
  }
  hypothesis->log_weight += ranked.log_ratio;
  UpdateReport report = hypothesis->map->apply(stamp, observations, std::move(assignments));
  for (std::size_t k = 0; k < report.assignments.size(); ++k) {
    const Assignment& assignment = report.assignments[k];
    hypothesis->decisions.push_back({stamp, observations[k].detection, assignment});
    if (!is_accepted(assignment.verdict)) continue;
    if (assignment.verdict == Verdict::kCreated) hypothesis->provisional_weight[assignment.landmark] = 0.0;
    const auto weight = hypothesis->provisional_weight.find(assignment.landmark);
    if (weight != hypothesis->provisional_weight.end()) weight->second += ranked.log_ratios[k];
  }
  for (const int landmark : report.confirmed) hypothesis->provisional_weight.erase(landmark);
  for (const int landmark : report.removed) forget(landmark, hypothesis);
  for (const auto& [dropped, kept] : report.merged) {
    hypothesis->provisional_weight.erase(dropped);
    for (Decision& decision : hypothesis->decisions) {
      if (decision.assignment.landmark == dropped) decision.assignment.landmark = kept;
    }
  }
  return report;
}

template <class Space>
void MultiHypothesis<Space>::forget(int landmark, Hypothesis* hypothesis) {
  const auto weight = hypothesis->provisional_weight.find(landmark);
  if (weight != hypothesis->provisional_weight.end()) {
    hypothesis->log_weight -= weight->second;
    hypothesis->provisional_weight.erase(weight);
  }
  for (Decision& decision : hypothesis->decisions) {
    if (is_accepted(decision.assignment.verdict) && decision.assignment.landmark == landmark) {
      decision.assignment = {Verdict::kClutter};
    }
  }
}

/// Hypotheses that have come to the same map and pose, as far as these are known, tell nothing apart any
/// more: the likeliest stays.
template <class Space>
void MultiHypothesis<Space>::drop_the_same() {
  std::stable_sort(
      hypotheses_.begin(), hypotheses_.end(),
      [](const Hypothesis& left, const Hypothesis& right) { return left.log_weight > right.log_weight; });
  if (hypotheses_.size() == 1) return;
  std::vector<Hypothesis> kept;
  std::vector<Belief> beliefs;
  for (Hypothesis& hypothesis : hypotheses_) {
    Belief belief{hypothesis.map->pose(), hypothesis.map->landmarks()};
    const auto is_provisional = [](const auto& landmark) { return !landmark.info.confirmed; };
    belief.landmarks.erase(std::remove_if(belief.landmarks.begin(), belief.landmarks.end(), is_provisional),
                           belief.landmarks.end());
    const bool is_new = std::none_of(beliefs.begin(), beliefs.end(),
                                     [&](const Belief& other) { return is_same(other, belief); });
    if (!is_new) continue;
    kept.push_back(std::move(hypothesis));
    beliefs.push_back(std::move(belief));
  }
  hypotheses_ = std::move(kept);
}

template <class Space>
bool MultiHypothesis<Space>::is_same(const Belief& left, const Belief& right) {
  if (left.landmarks.size() != right.landmarks.size()) return false;
  const typename Space::PoseVector between =
      pose_error<Space>(left.pose.map_from_base, right.pose.map_from_base);
  const auto apart = squared_mahalanobis<Space::kPoseDim>(between, left.pose.covariance);
  if (!apart || *apart > kSame) return false;
  return std::all_of(left.landmarks.begin(), left.landmarks.end(), [&](const auto& landmark) {
    return std::any_of(right.landmarks.begin(), right.landmarks.end(), [&](const auto& other) {
      const typename Space::Point difference = other.position_in_map - landmark.position_in_map;
      const auto distance = squared_mahalanobis<Space::kPointDim>(difference, landmark.covariance);
      return distance && *distance < kSame;
    });
  });
}

/// What the best hypothesis held `decide_after` ago is final: others that differ there are dropped.
template <class Space>
void MultiHypothesis<Space>::decide(TimeNs stamp) {
  const TimeNs final_before = stamp - to_nanoseconds(options_.decide_after);
  const auto differs = [&](const Hypothesis& hypothesis) {
    auto mine = hypothesis.decisions.begin();
    for (const Decision& decision : best().decisions) {
      if (decision.stamp >= final_before) break;
      if (mine == hypothesis.decisions.end() || !(*mine == decision)) return true;
      ++mine;
    }
    return false;
  };
  hypotheses_.erase(std::remove_if(hypotheses_.begin() + 1, hypotheses_.end(), differs), hypotheses_.end());
}

template <class Space>
void MultiHypothesis<Space>::tell_revisions(TimeNs stamp, UpdateReport* report) {
  auto now = best().decisions.begin();
  for (Decision& told : told_) {
    if (!(told == *now)) {
      told = *now;
      report->revisions.push_back({told.stamp, told.detection, told.assignment});
    }
    ++now;
  }
  const TimeNs final_before = stamp - to_nanoseconds(options_.decide_after);
  const auto forget_old = [&](std::deque<Decision>* decisions) {
    while (!decisions->empty() && decisions->front().stamp < final_before) decisions->pop_front();
  };
  forget_old(&told_);
  for (Hypothesis& hypothesis : hypotheses_) forget_old(&hypothesis.decisions);
}

template <class Space>
int MultiHypothesis<Space>::new_id(std::size_t observation) {
  const auto [id, is_new] = ids_of_frame_.emplace(observation, unused_id_);
  if (is_new) ++unused_id_;
  return id->second;
}

template <class Space>
void MultiHypothesis<Space>::restore(const SlamState<Space>& state) {
  hypotheses_.resize(1);
  hypotheses_[0].map->restore(state);
  hypotheses_[0].decisions.clear();
  hypotheses_[0].provisional_weight.clear();
  told_.clear();
  unused_id_ = 0;
  for (const LandmarkInfo& info : state.infos) unused_id_ = std::max(unused_id_, info.id + 1);
}

template <class Space>
void MultiHypothesis<Space>::set_pose(const PoseEstimate<Space>& pose) {
  hypotheses_.resize(1);  // it is told where the robot is: the others were wrong
  hypotheses_[0].map->set_pose(pose);
}

template <class Space>
void MultiHypothesis<Space>::set_map_fixed(bool fixed) {
  for (Hypothesis& hypothesis : hypotheses_) hypothesis.map->set_map_fixed(fixed);
}

template class MultiHypothesis<Planar>;
template class MultiHypothesis<Spatial>;

}  // namespace kinect_ekf_slam
