#pragma once

#include <utility>
#include <vector>

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/mapping/local_map.h"

namespace kinect_ekf_slam {

/// Landmarks of two maps that are the same: pairs of indices of the first and of the second one's points.
///
/// The second map's frame is the pose of the first state, with the covariance of that. Then the second map is
/// what a robot sees that stands there: all of its landmarks are sightings of one time, and who is who is
/// decided as for those, jointly, because an error of the frame moves them all together. What correlates the
/// errors of the second map within itself is not looked at; a pair is tested again with it when it is merged.
/// Path points have no part.
template <class Space>
std::vector<std::pair<int, int>> common_landmarks(const SlamState<Space>& first,
                                                  const SlamState<Space>& second,
                                                  const Associator<Space>& associator);

}  // namespace kinect_ekf_slam
