#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <vector>

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/estimators/options.h"

namespace kinect_ekf_slam {

/// Decides which landmarks were misplaced by a misread identity: those that `replace_after` sightings in a
/// row contradict, and no more than as many support. (docs/theory.md, section 4.)
class Contradictions {
 public:
  explicit Contradictions(const EstimatorOptions& options) : replace_after_(options.replace_after) {}

  /// Takes in what became of one message's sightings, and returns those that are to place their landmark
  /// anew: their indices, one a landmark. `assignments` name a landmark by any number that stays with it;
  /// `observations_of` says how many sightings support it.
  std::vector<std::size_t> misplaced(const std::vector<Assignment>& assignments,
                                     const std::function<int(int landmark)>& observations_of);
  void forget(int landmark) { in_a_row_.erase(landmark); }
  void clear() { in_a_row_.clear(); }

 private:
  int replace_after_;            ///< 0: never
  std::map<int, int> in_a_row_;  ///< refused sightings by landmark
};

}  // namespace kinect_ekf_slam
