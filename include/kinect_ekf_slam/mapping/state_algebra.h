#pragma once

#include <vector>

#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

// What can be done with whole states, pose and points with their joint covariance (docs/theory.md, section
// 13).

/// Two maps, the second in the frame of the first one's pose, become one in the frame of the first (map
/// joining: Tardos, Neira, Newman and Leonard, Int. J. Robotics Research 21(4), 2002). The pose is that of
/// the second, the points are the first one's, then the second one's. The errors of the two are independent.
template <class Space>
SlamState<Space> joined_states(const SlamState<Space>& first, const SlamState<Space>& second);

/// The points, so far seen from the pose, in the pose's own map: L = R l + t with the correlations of both.
template <class Space>
SlamState<Space> moved_by_pose(const SlamState<Space>& state);

/// Two states whose errors are independent, in one frame. The pose is the first one's; the second one's is
/// left out.
template <class Space>
SlamState<Space> side_by_side(const SlamState<Space>& first, const SlamState<Space>& second);

/// Only these points, by their indices; the pose stays.
template <class Space>
SlamState<Space> with_points(const SlamState<Space>& state, const std::vector<int>& points);

/// Two points, by their indices, are one: their difference is zero, equation (10.1). False, and nothing is
/// changed, when its squared Mahalanobis distance is not below the gate. What was known of the dropped one
/// goes to the kept one; the dropped one stays in the state, now equal to it.
template <class Space>
bool merge_points(int kept, int dropped, double gate, SlamState<Space>* state);

}  // namespace kinect_ekf_slam
