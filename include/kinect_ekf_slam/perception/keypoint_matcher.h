#pragma once

#include <vector>

#include "kinect_ekf_slam/perception/keypoints.h"

namespace kinect_ekf_slam {

struct MatchOptions {
  double ratio = 0.8;           ///< largest distance of the best to that of the second best descriptor
  double epipolar_error = 2.0;  ///< pixels between a keypoint and its epipolar line
  int fewest = 15;              ///< pairs that must agree on one motion, or there are none
};

/// The same spot in two pictures.
struct KeypointPair {
  int first = 0;  ///< index of the keypoint
  int second = 0;
};

/// Pairs of keypoints that look alike, better than any other by the ratio of their distances (Lowe, IJCV
/// 60(2), 2004), and that agree on one fundamental matrix (RANSAC: Fischler and Bolles, CACM 24(6), 1981).
/// No keypoint is in two pairs.
std::vector<KeypointPair> match(const Keypoints& first, const Keypoints& second, const MatchOptions& options);

}  // namespace kinect_ekf_slam
