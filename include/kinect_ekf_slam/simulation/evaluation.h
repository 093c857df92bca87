#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

template <class Space>
using Points = std::vector<typename Space::Point>;

/// The motion that brings `source` nearest to `target`, point by point, in the sense of least squares
/// (Umeyama 1991, without scale). With a single pair there is no turn; with none, no motion.
template <class Space>
typename Space::Pose align(const Points<Space>& target, const Points<Space>& source);

/// How a map differs from the truth.
struct MapComparison {
  std::size_t true_landmarks = 0;
  std::size_t estimated_landmarks = 0;
  std::size_t matched = 0;
  std::vector<std::pair<std::size_t, std::size_t>>
      pairs;                  ///< of those: which true one is which estimated one
  double rmse_aligned = 0.0;  ///< m, of the matched pairs after the best motion
  double rmse = 0.0;          ///< m, of the same pairs as they are
  double max_aligned = 0.0;   ///< m

  std::size_t missed() const { return true_landmarks - matched; }
  std::size_t spurious() const { return estimated_landmarks - matched; }
};

/// Both maps in one frame, up to an error of the estimate's pose. Landmarks match as mutual nearest
/// neighbours within `largest_distance` (m), again after the alignment by the pairs, until the pairs stay.
/// The figures are NaN when nothing matches.
template <class Space>
MapComparison compare_maps(const Points<Space>& truth, const Points<Space>& estimate,
                           double largest_distance = 0.5);

}  // namespace kinect_ekf_slam
