#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>
#include <vector>

namespace kinect_ekf_slam {

/// A beacon as a list tells it: known well, or roughly and then estimated.
struct Beacon {
  int id = 0;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();  ///< m
  double sigma = 0.0;                                         ///< m, each axis; never zero
};

/// How positions and ranges to beacons enter the estimate (docs/theory.md, section 11).
struct PositionOptions {
  /// Share of the true ones that the gate lets through.
  double gate_probability = 0.9999;
  double correlation_time = 0.0;  ///< s over which errors of positions resemble each other
  /// s that nothing else than refused positions and ranges come before it is the estimate that is wrong.
  double lost_after = 10.0;
  /// deg; the map lies where it does in the frame of the positions once the heading is known so well.
  double align_heading_sigma_deg = 5.0;
  std::vector<Beacon> beacons;
  /// s after the run's first frame, from and to: positions that are compared, but not used.
  std::vector<std::pair<double, double>> withheld;

  /// `since_start` s.
  bool is_withheld(double since_start) const {
    return std::any_of(withheld.begin(), withheld.end(), [&](const auto& stretch) {
      return since_start >= stretch.first && since_start < stretch.second;
    });
  }
};

}  // namespace kinect_ekf_slam
