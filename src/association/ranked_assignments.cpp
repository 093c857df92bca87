#include "kinect_ekf_slam/association/ranked_assignments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/association/joint_innovation.h"
#include "kinect_ekf_slam/core/position.h"

namespace kinect_ekf_slam {
namespace {

/// A way to explain the first sightings, and what it makes the next ones look like.
template <class Space>
struct Beam {
  RankedAssignment ranked;
  JointInnovation<Space> joint;
};

struct Option {
  Assignment assignment;
  double log_ratio;
};

/// Far below the best, an option is dropped; clutter, which is always possible, sooner than others.
void drop_unlikely(const AssociationOptions& options, std::vector<Option>* choices) {
  double best = -std::numeric_limits<double>::infinity();
  for (const Option& choice : *choices) best = std::max(best, choice.log_ratio);
  const auto is_unlikely = [&](const Option& choice) {
    const bool is_clutter = choice.assignment.verdict == Verdict::kClutter;
    return choice.log_ratio < best - (is_clutter ? options.clutter_width : options.branch_width);
  };
  choices->erase(std::remove_if(choices->begin(), choices->end(), is_unlikely), choices->end());
}

template <class Space>
bool is_matched(const RankedAssignment& ranked, int landmark) {
  return std::any_of(ranked.assignments.begin(), ranked.assignments.end(), [&](const Assignment& made) {
    return made.verdict == Verdict::kMatched && made.landmark == landmark;
  });
}

}  // namespace

/// Nothing that the map or this time's other new landmarks hold stands there, as far as the sensor could
/// tell: the pose's uncertainty has no part in it, or after a blind drive nothing would be new.
template <class Space>
bool AssignmentRanking<Space>::is_free(std::size_t k, const std::vector<Observation<Space>>& observations,
                                       const PredictedMap<Space>& map, const RankedAssignment& ranked) const {
  const auto is_apart = [&](const typename Space::Point& other) {
    const typename Space::Point difference = observations[k].position_in_base - other;
    if (difference.norm() < options_.new_landmark_distance) return false;
    const auto distance = squared_mahalanobis<Space::kPointDim>(difference, observations[k].covariance);
    return distance && *distance >= gates_.new_landmark();
  };
  for (int landmark = 0; landmark < map.size(); ++landmark) {
    if (!is_beacon(map.info(landmark).id) && !is_apart(map.point_in_base(landmark))) return false;
  }
  for (std::size_t other = 0; other < observations.size(); ++other) {
    const bool is_new = ranked.assignments[other].verdict == Verdict::kCreated;
    if (is_new && !is_apart(observations[other].position_in_base)) return false;
  }
  return true;
}

template <class Space>
std::vector<RankedAssignment> AssignmentRanking<Space>::rank(
    const std::vector<Observation<Space>>& observations, const PredictedMap<Space>& map, bool may_add) const {
  const double log_clutter = std::log(options_.clutter_density);
  const double log_new = std::log(options_.new_landmark_density) - log_clutter;
  std::vector<std::vector<GatedPair>> candidates(observations.size());
  for (const GatedPair& pair : gates_.pair(observations, map).pairs) {
    candidates[pair.observation].push_back(pair);
  }
  std::vector<std::size_t> nearest_first(observations.size());
  std::iota(nearest_first.begin(), nearest_first.end(), 0);
  std::stable_sort(nearest_first.begin(), nearest_first.end(), [&](std::size_t left, std::size_t right) {
    return observations[left].position_in_base.norm() < observations[right].position_in_base.norm();
  });

  RankedAssignment unexplained;
  unexplained.assignments.assign(observations.size(), {Verdict::kClutter});
  unexplained.log_ratios.assign(observations.size(), 0.0);
  std::vector<Beam<Space>> beams{{std::move(unexplained), JointInnovation<Space>(map)}};
  for (const std::size_t k : nearest_first) {
    std::vector<Beam<Space>> extended;
    for (Beam<Space>& beam : beams) {
      std::vector<Option> choices{{{Verdict::kClutter}, 0.0}};
      if (may_add && is_free(k, observations, map, beam.ranked)) {
        choices.push_back({{Verdict::kCreated}, log_new});
      }
      for (const GatedPair& pair : candidates[k]) {
        if (is_matched<Space>(beam.ranked, pair.landmark)) continue;
        const auto increment = beam.joint.push(observations[k], pair.landmark);
        if (!increment) continue;
        beam.joint.pop();
        if (increment->squared_distance >= gates_.joint(1)) continue;
        const double attributes =
            attribute_distance(observations[k].signature, map.info(pair.landmark), options_);
        choices.push_back({{Verdict::kMatched, pair.landmark, increment->squared_distance},
                           increment->log_likelihood() - 0.5 * attributes - log_clutter});
      }
      drop_unlikely(options_, &choices);
      for (const Option& choice : choices) {
        Beam<Space> next = beam;
        if (choice.assignment.verdict == Verdict::kMatched) {
          next.joint.push(observations[k], choice.assignment.landmark);
        }
        next.ranked.assignments[k] = choice.assignment;
        next.ranked.log_ratios[k] = choice.log_ratio;
        next.ranked.log_ratio += choice.log_ratio;
        extended.push_back(std::move(next));
      }
    }
    std::stable_sort(extended.begin(), extended.end(), [](const Beam<Space>& left, const Beam<Space>& right) {
      return left.ranked.log_ratio > right.ranked.log_ratio;
    });
    const double worst = extended.front().ranked.log_ratio - options_.branch_width;
    while (extended.back().ranked.log_ratio < worst ||
           extended.size() > static_cast<std::size_t>(options_.max_hypotheses)) {
      extended.pop_back();
    }
    beams = std::move(extended);
  }
  std::vector<RankedAssignment> ranked;
  ranked.reserve(beams.size());
  for (Beam<Space>& beam : beams) ranked.push_back(std::move(beam.ranked));
  return ranked;
}

template class AssignmentRanking<Planar>;
template class AssignmentRanking<Spatial>;

}  // namespace kinect_ekf_slam
