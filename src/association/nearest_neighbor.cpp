#include "kinect_ekf_slam/association/nearest_neighbor.h"

#include <algorithm>
#include <tuple>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/chi_square.h"

namespace kinect_ekf_slam {
namespace {

struct Pair {
  double squared_distance;
  std::size_t observation;
  int landmark;
  bool operator<(const Pair& other) const {
    return std::tie(squared_distance, observation, landmark) <
           std::tie(other.squared_distance, other.observation, other.landmark);
  }
};

}  // namespace

template <class Space>
NearestNeighbor<Space>::NearestNeighbor(const AssociationOptions& options)
    : gate_(chi_square_quantile(options.gate_probability, Space::kPointDim)),
      new_landmark_gate_(chi_square_quantile(options.new_landmark_probability, Space::kPointDim)),
      new_landmark_distance_(options.new_landmark_distance) {}

template <class Space>
AssociationReach NearestNeighbor<Space>::reach() const {
  return {std::max(gate_, new_landmark_gate_), new_landmark_distance_};
}

/// A detector that sees two where there is one: of new sightings that may be one object, the nearest counts.
template <class Space>
void NearestNeighbor<Space>::refuse_echoes(const typename Associator<Space>::Observations& observations,
                                           std::vector<Assignment>* assignments) const {
  std::vector<std::size_t> unmapped;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if ((*assignments)[k].verdict == Verdict::kCreated) unmapped.push_back(k);
  }
  std::stable_sort(unmapped.begin(), unmapped.end(), [&](std::size_t left, std::size_t right) {
    return observations[left].position_in_base.norm() < observations[right].position_in_base.norm();
  });
  std::vector<std::size_t> kept;
  for (const std::size_t k : unmapped) {
    const bool is_echo = std::any_of(kept.begin(), kept.end(), [&](std::size_t other) {
      const typename Space::Point difference =
          observations[k].position_in_base - observations[other].position_in_base;
      const auto distance = squared_mahalanobis<Space::kPointDim>(
          difference, observations[k].covariance + observations[other].covariance);
      return !distance || *distance < gate_ || difference.norm() < new_landmark_distance_;
    });
    if (is_echo) {
      (*assignments)[k].verdict = Verdict::kDuplicateIdentity;
    } else {
      kept.push_back(k);
    }
  }
}

template <class Space>
std::vector<Assignment> NearestNeighbor<Space>::associate(
    const typename Associator<Space>::Observations& observations, const PredictedMap<Space>& map) const {
  std::vector<Assignment> assignments(observations.size());
  for (Assignment& assignment : assignments)
    assignment.verdict = Verdict::kCreated;  // until a landmark objects

  std::vector<Pair> candidates;
  for (int landmark = 0; landmark < map.size(); ++landmark) {
    const typename Space::Point expected = map.point_in_base(landmark);
    const typename Space::PointMatrix covariance = map.covariance(landmark);
    for (std::size_t k = 0; k < observations.size(); ++k) {
      const typename Space::Point innovation = observations[k].position_in_base - expected;
      const auto distance =
          squared_mahalanobis<Space::kPointDim>(innovation, covariance + observations[k].covariance);
      Assignment& assignment = assignments[k];
      if (!distance) {
        assignment.verdict = Verdict::kSingular;
        continue;
      }
      const bool objects = *distance < new_landmark_gate_ || innovation.norm() < new_landmark_distance_;
      if (*distance < gate_) {
        candidates.push_back({*distance, k, landmark});
      } else if (objects &&
                 (assignment.verdict == Verdict::kCreated ||
                  (assignment.verdict == Verdict::kAmbiguous && *distance < assignment.squared_distance))) {
        assignment = {Verdict::kAmbiguous, landmark, *distance};
      } else if (assignment.verdict == Verdict::kCreated && !(assignment.squared_distance <= *distance)) {
        assignment.squared_distance = *distance;
      }
    }
  }

  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> landmark_taken(map.size(), false);
  for (const Pair& pair : candidates) {
    Assignment& assignment = assignments[pair.observation];
    if (assignment.verdict == Verdict::kMatched) continue;
    const bool taken = landmark_taken[pair.landmark];
    if (taken && assignment.verdict == Verdict::kDuplicateIdentity) continue;
    assignment = {taken ? Verdict::kDuplicateIdentity : Verdict::kMatched, pair.landmark,
                  pair.squared_distance};
    if (!taken) landmark_taken[pair.landmark] = true;
  }
  refuse_echoes(observations, &assignments);
  return assignments;
}

template class NearestNeighbor<Planar>;
template class NearestNeighbor<Spatial>;

}  // namespace kinect_ekf_slam
