#include "kinect_ekf_slam/association/known_identity.h"

#include <unordered_map>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/chi_square.h"

namespace kinect_ekf_slam {
namespace {

/// Of two observations of one identity, is the `challenger` the one to keep? In doubt the nearer one is.
template <class Space>
bool fits_better(const Assignment& challenger, const Observation<Space>& challenger_seen,
                 const Assignment& holder, const Observation<Space>& holder_seen) {
  if (is_accepted(challenger.verdict) != is_accepted(holder.verdict)) return is_accepted(challenger.verdict);
  if (challenger.verdict == Verdict::kMatched) return challenger.squared_distance < holder.squared_distance;
  return challenger_seen.position_in_base.norm() < holder_seen.position_in_base.norm();
}

}  // namespace

template <class Space>
KnownIdentity<Space>::KnownIdentity(const AssociationOptions& options)
    : gate_(chi_square_quantile(options.gate_probability, Space::kPointDim)) {}

template <class Space>
std::vector<Assignment> KnownIdentity<Space>::associate(
    const typename Associator<Space>::Observations& observations, const PredictedMap<Space>& map) const {
  constexpr int kNone = -1;
  std::unordered_map<int, int> landmark_of_identity;  // of those that are seen
  for (const Observation<Space>& observation : observations) {
    landmark_of_identity.emplace(observation.signature.source_id, kNone);
  }
  for (int i = 0; i < map.size(); ++i) {
    const auto seen = landmark_of_identity.find(map.info(i).source_id);
    if (seen != landmark_of_identity.end()) seen->second = i;
  }

  std::vector<Assignment> assignments(observations.size());
  std::unordered_map<int, std::size_t> holder_of_identity;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    const Observation<Space>& observation = observations[k];
    Assignment& assignment = assignments[k];
    const int identity = observation.signature.source_id;
    if (identity == kNoId) {
      assignment.verdict = Verdict::kNoIdentity;
      continue;
    }
    const int known = landmark_of_identity.at(identity);
    if (known == kNone) {
      assignment.verdict = Verdict::kCreated;
    } else {
      assignment.landmark = known;
      const auto distance =
          squared_mahalanobis<Space::kPointDim>(observation.position_in_base - map.point_in_base(known),
                                                map.covariance(known) + observation.covariance);
      assignment.squared_distance = distance.value_or(assignment.squared_distance);
      assignment.verdict = !distance           ? Verdict::kSingular
                           : *distance < gate_ ? Verdict::kMatched
                                               : Verdict::kOutsideGate;
    }
    const auto [holder, is_first] = holder_of_identity.emplace(identity, k);
    if (is_first) continue;
    std::size_t loser = k;
    if (fits_better(assignment, observation, assignments[holder->second], observations[holder->second])) {
      std::swap(loser, holder->second);
    }
    if (is_accepted(assignments[loser].verdict)) assignments[loser].verdict = Verdict::kDuplicateIdentity;
  }
  return assignments;
}

template class KnownIdentity<Planar>;
template class KnownIdentity<Spatial>;

}  // namespace kinect_ekf_slam
