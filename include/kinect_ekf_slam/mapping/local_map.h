#pragma once

#include <vector>

#include "kinect_ekf_slam/core/stamped.h"
#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

/// Ids below this one are no landmarks: they are places where the robot was, kept in the state like landmarks
/// that nobody sees, so that all that is learnt later about the way corrects them, and their errors'
/// correlations with each other and with the landmarks are known. (Delayed states; docs/theory.md,
/// section 13.)
constexpr int kFirstPathPoint = kNoId - 1;

inline bool is_path_point(const LandmarkInfo& info) { return info.id <= kFirstPathPoint; }

/// A stretch of the robot's way with the map that was made on it, in a frame of its own: the robot's pose at
/// `start`.
template <class Space>
struct LocalMap {
  TimeNs start = 0;
  TimeNs end = 0;
  /// The pose at `end`, the landmarks, and among them the path points in the order of their times.
  SlamState<Space> state;
  std::vector<TimeNs> path_stamps;  ///< of the path points, ascending, from `start` to `end`
  /// The pose at each look, and where nobody looked now and then, as it was known then.
  std::vector<Stamped<PoseEstimate<Space>>> poses;
  /// The next map starts where this one ends: false when the robot may have been carried in between.
  bool leads_to_next = true;

  /// Indices of the path points among the points of the state.
  std::vector<int> path_points() const {
    std::vector<int> indices;
    for (std::size_t i = 0; i < state.infos.size(); ++i) {
      if (is_path_point(state.infos[i])) indices.push_back(static_cast<int>(i));
    }
    return indices;
  }
};

}  // namespace kinect_ekf_slam
