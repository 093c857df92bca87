#include "kinect_ekf_slam/association/nearest_neighbor.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace kinect_ekf_slam {

template <class Space>
std::vector<Assignment> NearestNeighbor<Space>::associate(
    const typename Associator<Space>::Observations& observations, const PredictedMap<Space>& map) const {
  GatedPairs<Space> gated = gates_.pair(observations, map);
  std::sort(gated.pairs.begin(), gated.pairs.end(), [](const GatedPair& left, const GatedPair& right) {
    return std::tie(left.squared_distance, left.observation, left.landmark) <
           std::tie(right.squared_distance, right.observation, right.landmark);
  });
  std::vector<Assignment> assignments = std::move(gated.otherwise);
  std::vector<bool> landmark_taken(map.size(), false);
  for (const GatedPair& pair : gated.pairs) {
    Assignment& assignment = assignments[pair.observation];
    if (assignment.verdict == Verdict::kMatched) continue;
    const bool taken = landmark_taken[pair.landmark];
    if (taken && assignment.verdict == Verdict::kDuplicateIdentity) continue;
    assignment = {taken ? Verdict::kDuplicateIdentity : Verdict::kMatched, pair.landmark,
                  pair.squared_distance};
    if (!taken) landmark_taken[pair.landmark] = true;
  }
  gates_.refuse_echoes(observations, &assignments);
  return assignments;
}

template class NearestNeighbor<Planar>;
template class NearestNeighbor<Spatial>;

}  // namespace kinect_ekf_slam
