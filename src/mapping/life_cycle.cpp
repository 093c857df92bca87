#include "kinect_ekf_slam/mapping/life_cycle.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/mapping/local_map.h"

namespace kinect_ekf_slam {
namespace {

constexpr TimeNs kMergeInterval = 1000000000;
constexpr double kTogether =
    0.02;  // share of the rarer one's sightings in which duplicates may appear as two
constexpr double kTwinShare = 0.5;  // seen so much less often than what stands beside it: one seen double
constexpr double kTwinReach = 1.5;  // merge distances
constexpr double kLeastDetectionRate = 0.25;  // of what is there, in the looks that should show it
constexpr double kVisitsApart = 5.0;          // s; looks in vain farther apart belong to different visits
constexpr int kLooksOfVisit = 3;              // fewer say nothing: one look is missed easily
constexpr double kMissedByChance = 0.001;     // that so many looks in a row missed what is there
constexpr int kSightingsPerVisit = 10;        // support that outweighs one visit in vain
constexpr double kWellInside = 0.85;  // share of the view in which a landmark must be seen, if it is there
constexpr double kBodyWidth = 0.3;    // m; what stands nearer in the same direction hides what is behind
constexpr double kBodyDepth = 0.1;    // m; what stands nearer by less than this stands beside it

}  // namespace

template <class Space>
LifeCycle<Space>::LifeCycle(const LifeCycleOptions& options)
    : options_(options), merge_gate_(chi_square_quantile(options.merge_probability, Space::kPointDim)) {}

template <class Space>
void LifeCycle<Space>::keep(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                            KalmanSlam<Space>* filter, UpdateReport* report) {
  count_sightings(stamp, filter, report);
  if (options_.remove_after_visits > 0) count_misses(stamp, observations, filter, report);
  remove_unlikely(stamp, filter, report);
  if (options_.merge_distance > 0.0 && stamp - last_merged_ >= kMergeInterval) {
    last_merged_ = stamp;
    merge_duplicates(filter, report);
  }
}

template <class Space>
void LifeCycle<Space>::count_sightings(TimeNs stamp, KalmanSlam<Space>* filter, UpdateReport* report) {
  std::vector<int> seen;
  for (const Assignment& assignment : report->assignments) {
    if (is_accepted(assignment.verdict)) seen.push_back(assignment.landmark);
  }
  std::sort(seen.begin(), seen.end());
  const typename Space::Pose pose = filter->pose().map_from_base;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t j = i + 1; j < seen.size(); ++j) ++seen_together_[{seen[i], seen[j]}];
  }
  for (auto& [id, record] : records_) {
    if (record.confirmed) continue;
    for (const int other : seen) ++record.company[other];
  }
  for (const Assignment& assignment : report->assignments) {
    if (!is_accepted(assignment.verdict)) continue;
    const int id = assignment.landmark;
    if (assignment.verdict == Verdict::kCreated) {
      records_[id] = Record{};  // one that is placed anew keeps its id, not its record
      records_[id].first_seen = stamp;
      records_[id].first_seen_from = pose;
      filter->set_confirmed(id, false);
    }
    const auto record = records_.find(id);
    if (record == records_.end()) continue;
    Record& seen_again = record->second;
    if (assignment.verdict == Verdict::kMatched && !seen_again.confirmed) ++report->provisional;
    if (seen_again.sightings > 0 && to_seconds(stamp - seen_again.last_seen) > kVisitsApart)
      ++seen_again.visits;
    seen_again.last_seen = stamp;
    ++seen_again.sightings;
    seen_again.start_visit();
    seen_again.visits_in_vain = 0;
    if (seen_again.confirmed || !deserves_belief(seen_again, pose)) continue;
    if (is_twin(id, seen_again, *filter)) continue;
    seen_again.confirmed = true;
    seen_again.company.clear();
    filter->set_confirmed(id, true);
    report->confirmed.push_back(id);
  }
}

template <class Space>
bool LifeCycle<Space>::deserves_belief(const Record& record,
                                       const typename Space::Pose& map_from_base) const {
  if (options_.confirm_sightings <= 1) return true;
  if (record.sightings < options_.confirm_sightings) return false;
  if (record.detection_rate() < kLeastDetectionRate) return false;
  if (to_seconds(record.last_seen - record.first_seen) < options_.confirm_time) return false;
  const typename Space::PoseVector motion = (record.first_seen_from.inverse() * map_from_base).log();
  return motion.norm() >= options_.confirm_motion;
}

template <class Space>
bool LifeCycle<Space>::is_twin(int id, const Record& record, const KalmanSlam<Space>& filter) const {
  std::set<int> seen_more;
  for (const auto& [other, frames] : record.company) {
    if (record.sightings <= kTwinShare * frames) seen_more.insert(other);
  }
  if (seen_more.empty()) return false;
  const std::vector<LandmarkEstimate<Space>> landmarks = filter.landmarks();
  const auto self = std::find_if(landmarks.begin(), landmarks.end(),
                                 [&](const auto& landmark) { return landmark.info.id == id; });
  return std::any_of(landmarks.begin(), landmarks.end(), [&](const auto& other) {
    const double distance = (other.position_in_map - self->position_in_map).norm();
    return seen_more.count(other.info.id) > 0 && distance < kTwinReach * options_.merge_distance;
  });
}

template <class Space>
bool LifeCycle<Space>::is_in_view(const typename Space::Point& point_in_base) const {
  const Eigen::Vector3d point = Space::to_3d(point_in_base);
  const double range = point.norm();
  const auto is_within = [](double angle, double view_deg) {
    return std::abs(angle) < kWellInside * 0.5 * radians(view_deg);
  };
  return range > kBodyWidth && range < kWellInside * options_.view_range &&
         is_within(std::atan2(point.y(), point.x()), options_.field_of_view_deg) &&
         is_within(std::asin(point.z() / range), options_.vertical_field_of_view_deg);
}

/// A landmark may be hidden by what stands nearer in its direction, and by a refused sighting at about its
/// range, for that may be the landmark itself.
template <class Space>
bool LifeCycle<Space>::is_hidden(const typename Space::Point& point_in_base,
                                 const std::vector<Observation<Space>>& observations,
                                 const std::vector<Assignment>& assignments) const {
  const double range = point_in_base.norm();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const typename Space::Point& other = observations[i].position_in_base;
    const double along = other.dot(point_in_base) / range;
    const double across = (other - along / range * point_in_base).norm();
    const double farthest = range + (is_accepted(assignments[i].verdict) ? -kBodyDepth : kBodyWidth);
    if (along > 0.0 && along < farthest && across < kBodyWidth) return true;
  }
  return false;
}

/// A landmark well inside the view that nothing hides should have been seen.
template <class Space>
void LifeCycle<Space>::count_misses(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                                    KalmanSlam<Space>* filter, UpdateReport* report) {
  std::set<int> seen;
  for (const Assignment& assignment : report->assignments) {
    if (assignment.landmark >= 0) seen.insert(assignment.landmark);
  }
  const auto expected = filter->expect(observations);
  for (int i = 0; i < expected.size(); ++i) {
    const auto record = records_.find(expected.info(i).id);
    if (record == records_.end() || seen.count(record->first) > 0) continue;
    const typename Space::Point point = expected.point_in_base(i);
    if (!is_in_view(point) || is_hidden(point, observations, report->assignments)) continue;
    Record& missed = record->second;
    if (missed.confirmed) report->missed += missed.detection_rate();
    if (to_seconds(stamp - missed.last_missed) > kVisitsApart) missed.start_visit();
    missed.last_missed = stamp;
    ++missed.misses;
    ++missed.misses_of_visit;
    if (missed.is_in_vain || missed.misses_of_visit < kLooksOfVisit || missed.may_be_chance(kMissedByChance))
      continue;
    missed.is_in_vain = true;
    ++missed.visits_in_vain;
  }
}

template <class Space>
void LifeCycle<Space>::remove_unlikely(TimeNs stamp, KalmanSlam<Space>* filter, UpdateReport* report) {
  std::vector<int> unlikely;
  for (const auto& [id, record] : records_) {
    const bool never_confirmed =
        !record.confirmed && to_seconds(stamp - record.last_seen) > options_.forget_after;
    const int support = std::min(record.visits, record.sightings / kSightingsPerVisit);
    const int enough = std::min(options_.remove_after_visits, 1 + support);
    const bool is_not_there = options_.remove_after_visits > 0 && record.visits_in_vain >= enough;
    if (never_confirmed || is_not_there) unlikely.push_back(id);
  }
  for (const int id : unlikely) {
    records_.erase(id);
    if (filter->remove(id)) report->removed.push_back(id);
  }
}

/// The nearest two that may be one become one; the next ones wait for the next time.
template <class Space>
void LifeCycle<Space>::merge_duplicates(KalmanSlam<Space>* filter, UpdateReport* report) {
  struct Pair {
    double distance;  // m
    std::size_t kept;
    std::size_t dropped;
  };
  const std::vector<LandmarkEstimate<Space>> landmarks = filter->landmarks();
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (std::size_t j = i + 1; j < landmarks.size(); ++j) {
      const double distance = (landmarks[i].position_in_map - landmarks[j].position_in_map).norm();
      const bool has_beacon = is_beacon(landmarks[i].info.id) || is_beacon(landmarks[j].info.id);
      if (distance > options_.merge_distance || has_beacon) continue;
      if (is_path_point(landmarks[i].info) || is_path_point(landmarks[j].info)) continue;
      const bool keep_first = landmarks[i].info.observations >= landmarks[j].info.observations;
      pairs.push_back({distance, keep_first ? i : j, keep_first ? j : i});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& left, const Pair& right) { return left.distance < right.distance; });
  for (const Pair& pair : pairs) {
    const LandmarkInfo& kept = landmarks[pair.kept].info;
    const LandmarkInfo& dropped = landmarks[pair.dropped].info;
    const auto together = seen_together_.find({std::min(kept.id, dropped.id), std::max(kept.id, dropped.id)});
    if (together != seen_together_.end() && together->second > kTogether * dropped.observations) continue;
    if (!filter->merge(kept.id, dropped.id, merge_gate_)) continue;
    take_over(dropped.id, kept.id);
    report->merged.emplace_back(dropped.id, kept.id);
    return;
  }
}

template <class Space>
void LifeCycle<Space>::take_over(int dropped_id, int kept_id) {
  const auto dropped = records_.find(dropped_id);
  const auto kept = records_.find(kept_id);
  const bool was_confirmed = dropped == records_.end() || dropped->second.confirmed;
  if (kept != records_.end()) kept->second.confirmed = kept->second.confirmed || was_confirmed;
  if (dropped != records_.end() && kept != records_.end()) {
    kept->second.sightings += dropped->second.sightings;
    kept->second.visits = std::max(kept->second.visits, dropped->second.visits);
    kept->second.last_seen = std::max(kept->second.last_seen, dropped->second.last_seen);
  }
  records_.erase(dropped_id);
  take_over_company(dropped_id, kept_id);
}

/// What was seen together with the one that goes was seen together with the one that stays.
template <class Space>
void LifeCycle<Space>::take_over_company(int dropped, int kept) {
  for (auto pair = seen_together_.begin(); pair != seen_together_.end();) {
    const auto [low, high] = pair->first;
    if (low != dropped && high != dropped) {
      ++pair;
      continue;
    }
    const int other = low == dropped ? high : low;
    if (other != kept) seen_together_[{std::min(kept, other), std::max(kept, other)}] += pair->second;
    pair = seen_together_.erase(pair);
  }
}

template class LifeCycle<Planar>;
template class LifeCycle<Spatial>;

}  // namespace kinect_ekf_slam
