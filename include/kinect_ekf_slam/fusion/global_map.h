#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/stamped.h"
#include "kinect_ekf_slam/fusion/alignment.h"
#include "kinect_ekf_slam/fusion/global_map_options.h"
#include "kinect_ekf_slam/mapping/local_map.h"

namespace kinect_ekf_slam {

/// Where a sensor that knows the global frame says that it is: an antenna on the robot.
template <class Space>
struct GlobalPlace {
  Gaussian<Space::kPointDim> antenna;                            ///< m, m^2
  typename Space::Point antenna_in_base = Space::Point::Zero();  ///< m: the lever arm
  std::optional<HeadingPrior<Space>> attitude;                   ///< of the base; absent: not measured
};

/// A stretch of the way in the global frame: one local map, or several that only together could be placed.
template <class Space>
struct GlobalSegment {
  int first_map = 0;  ///< local maps, counted from 0
  int last_map = 0;
  TimeNs start = 0;
  TimeNs end = 0;
  std::string refusal;  ///< why it could not be placed; empty: it was
  PoseEstimate<Space> global_from_local;
  std::size_t positions = 0;                                ///< global positions in its time
  std::vector<Stamped<Disagreement<Space>>> disagreements;  ///< of which these were left out
  /// The pose at each look. The position's covariance is that of all that is known; the turn's is the sum of
  /// those of the segment's frame and of the pose in it.
  std::vector<Stamped<PoseEstimate<Space>>> path;
};

/// One map and one path in the global frame.
template <class Space>
struct GlobalMap {
  std::vector<LandmarkEstimate<Space>>
      landmarks;                         ///< with ids of their own, or the identity where it is known
  std::vector<int> segment_of_landmark;  ///< the last segment that saw it
  std::vector<GlobalSegment<Space>> segments;
  int merged_landmarks = 0;  ///< that stood in several local maps
};

/// Lines 16 to 22 of the source's algorithm 3 (docs/theory.md, section 13): each local path as a spline,
/// paired by time with the global positions; the transform of its frame; path and landmarks in the global
/// frame; and all of them one map, in which a landmark of several local maps is one.
///
/// A local map that cannot be placed by itself is joined with its neighbour, through the pose at which the
/// one ends and the other starts and through the landmarks that both have, and they are placed together.
/// Where the places do not tell how it is turned, the surest attitude among them does. `places` ascend in
/// time; their errors are independent. Throws std::invalid_argument when they do not ascend.
template <class Space>
GlobalMap<Space> integrate_maps(const std::vector<LocalMap<Space>>& maps,
                                const std::vector<Stamped<GlobalPlace<Space>>>& places,
                                const GlobalMapOptions& options);

}  // namespace kinect_ekf_slam
