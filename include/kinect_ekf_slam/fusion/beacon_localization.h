#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/core/time.h"
#include "kinect_ekf_slam/estimators/gaussian.h"

namespace kinect_ekf_slam {

struct BeaconLocalizationOptions {
  /// m/s^1.5: how much the velocity changes in a second, each axis; the square is the density of a white
  /// acceleration.
  double acceleration_noise = 0.3;
  double gate_probability = 0.999;  ///< of one range; others are refused
  double max_fix_sigma = 3.0;       ///< m, along the worst axis; a fix less sure is none
};

/// Where something is that knows nothing but its distances to beacons: the source's buoy system. An extended
/// Kalman filter of position and velocity; what moves it is unknown, so the velocity is taken to be nearly
/// constant. (docs/theory.md, section 13. With odometry and a heading it is the SLAM filter without
/// landmarks.)
template <class Space>
class BeaconLocalization {
 public:
  static constexpr int kDim = Space::kPointDim;
  using Position = Gaussian<kDim>;
  using Beacons =
      std::map<int, Position>;  ///< by id: the place in the global frame, m, and how sure it is, m^2

  /// At rest at `position`, give or take 1 m/s.
  BeaconLocalization(Beacons beacons, const BeaconLocalizationOptions& options, TimeNs stamp,
                     const Position& position);

  /// What became of the ranges of one time.
  struct Report {
    int unknown = 0;  ///< ranges to no beacon of the list
    int refused = 0;  ///< ranges outside of the gate
    /// The place that these ranges tell alone, without the past: fixes of different times err independently,
    /// which the filter's positions do not. Nothing when they are too few or stand badly.
    std::optional<Position> fix;
  };
  /// Moves on to `stamp`, not before the last one, and takes in the ranges measured then.
  Report update(TimeNs stamp, const std::vector<BeaconRange>& ranges);

  /// The filter's estimate at the last update, m and m^2 in the global frame.
  Position position() const { return {state_.mean.template head<kDim>(), position_covariance()}; }

 private:
  static constexpr int kStateDim = 2 * kDim;
  using Row = Eigen::Matrix<double, 1, kDim>;
  /// A range as it is seen from a place.
  struct Linearized {
    double innovation;  // m
    Row by_position;
    double variance;  // m^2, with that of the beacon's place
  };

  std::optional<Linearized> linearize(const BeaconRange& range, const typename Space::Point& position) const;
  std::optional<Position> fix(const std::vector<BeaconRange>& ranges) const;
  typename Space::PointMatrix position_covariance() const {
    return state_.covariance.template topLeftCorner<kDim, kDim>();
  }
  void move_on(TimeNs stamp);

  Beacons beacons_;
  BeaconLocalizationOptions options_;
  double gate_;
  TimeNs now_;
  Gaussian<kStateDim> state_;  ///< position, velocity
};

}  // namespace kinect_ekf_slam
