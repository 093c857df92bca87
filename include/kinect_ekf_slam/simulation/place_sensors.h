#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <map>
#include <vector>

#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// A receiver that tells its place in the world, as GPS does.
struct GpsOptions {
  double rate = 0.0;           ///< Hz; 0: there is none
  double noise = 0.5;          ///< m of one fix, each axis; the height's is twice as large
  double drift = 0.0;          ///< m, of an error that lasts, each axis
  double drift_time = 60.0;    ///< s that it lasts
  double outlier_rate = 0.0;   ///< share of the fixes that jump ...
  double outlier_size = 20.0;  ///< ... so far along the ground, m
  double delay = 0.0;          ///< s between a fix and its message
  Eigen::Vector3d antenna_in_base = Eigen::Vector3d(0.0, 0.0, 0.3);  ///< m
};

/// Beacons, and a receiver that measures its distance from those that are near.
struct BeaconOptions {
  double rate = 0.0;          ///< Hz; 0: there is none
  double noise = 0.1;         ///< m of one range
  double max_range = 50.0;    ///< m
  double outlier_rate = 0.0;  ///< share of the ranges that are too long ...
  double outlier_size = 5.0;  ///< ... by up to so much, m: what has been reflected
  Eigen::Vector3d receiver_in_base = Eigen::Vector3d(0.0, 0.0, 0.3);  ///< m
  std::map<int, Eigen::Vector3d> places_in_world;                     ///< m, by the beacon's id
};

class GpsReceiver {
 public:
  GpsReceiver(const GpsOptions& options, RandomStream random);
  /// The covariance is that of noise and drift; the position that of the antenna, in the world.
  GlobalPosition read(TimeNs stamp, const Eigen::Isometry3d& world_from_base);

 private:
  Eigen::Vector3d draw();

  GpsOptions options_;
  RandomStream random_;
  Eigen::Vector3d drift_;  ///< m
  TimeNs last_ = 0;
};

class RangeReceiver {
 public:
  RangeReceiver(const BeaconOptions& options, RandomStream random);
  std::vector<BeaconRange> read(const Eigen::Isometry3d& world_from_base);

 private:
  BeaconOptions options_;
  RandomStream random_;
};

}  // namespace kinect_ekf_slam
