#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// Finds where the map lies in the frame of global positions: from the robot's way so far and what the
/// positions say of it, the shift and the turn about the vertical (docs/theory.md, section 11).
///
/// A heading that may be any angle is no small error: this is the closed form, not a filter with a wide
/// prior.
template <class Space>
class GlobalAlignment {
 public:
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  struct Pair {
    Point antenna_in_map = Point::Zero();                   ///< m, by the estimate
    PointMatrix antenna_covariance = PointMatrix::Zero();   ///< m^2
    Point position = Point::Zero();                         ///< m, as measured
    PointMatrix position_covariance = PointMatrix::Zero();  ///< m^2
  };
  struct Solution {
    Eigen::Isometry3d map_from_global = Eigen::Isometry3d::Identity();
    /// Of the map in the global frame: a shift, and a turn about the map's origin.
    typename Space::PoseMatrix covariance = Space::PoseMatrix::Zero();
    double heading_sigma = 0.0;  ///< rad
  };

  void add(const Pair& pair);
  /// Nothing while the positions contradict each other or the way; a quarter of them may be outliers.
  std::optional<Solution> solve() const;
  void clear() { pairs_.clear(); }

 private:
  struct Fit;

  std::vector<Pair> pairs_;  ///< thinned out when there are many
};

}  // namespace kinect_ekf_slam
