#pragma once

#include <vector>

#include "kinect_ekf_slam/association/gated_pairs.h"

namespace kinect_ekf_slam {

/// One way to explain all sightings of one time.
struct RankedAssignment {
  std::vector<Assignment> assignments;  ///< matched, created or clutter
  std::vector<double> log_ratios;       ///< of each, to its being clutter
  double log_ratio = 0.0;               ///< their sum
};

/// The likely ways to explain the sightings of one time.
///
/// Each sighting, nearest first, is a landmark of the map (a Gaussian about where it and the pairs before it
/// let expect it), a new landmark, or clutter, both spread evenly (docs/theory.md, section 10). A beam
/// search: at no time are there more than `max_hypotheses`, or any far less likely than the best.
template <class Space>
class AssignmentRanking {
 public:
  explicit AssignmentRanking(const AssociationOptions& options) : options_(options), gates_(options) {}

  /// The likeliest first; at least one. `may_add` false: no landmark is new.
  std::vector<RankedAssignment> rank(const std::vector<Observation<Space>>& observations,
                                     const PredictedMap<Space>& map, bool may_add) const;

 private:
  bool is_free(std::size_t k, const std::vector<Observation<Space>>& observations,
               const PredictedMap<Space>& map, const RankedAssignment& ranked) const;

  AssociationOptions options_;
  Gates<Space> gates_;
};

}  // namespace kinect_ekf_slam
