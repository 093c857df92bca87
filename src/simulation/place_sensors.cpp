#include "kinect_ekf_slam/simulation/place_sensors.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

const Eigen::Vector3d kAxes(1.0, 1.0, 2.0);  // a height is worse by so much

}  // namespace

GpsReceiver::GpsReceiver(const GpsOptions& options, RandomStream random)
    : options_(options), random_(random), drift_(options.drift * draw()) {}

Eigen::Vector3d GpsReceiver::draw() {
  const double x = random_.normal();  // one after the other: the order of arguments is not defined
  const double y = random_.normal();
  const double z = random_.normal();
  return kAxes.cwiseProduct(Eigen::Vector3d(x, y, z));
}

/// The drift is a Gauss-Markov process of steady variance.
GlobalPosition GpsReceiver::read(TimeNs stamp, const Eigen::Isometry3d& world_from_base) {
  const double kept = std::exp(-to_seconds(stamp - last_) / options_.drift_time);
  last_ = stamp;
  drift_ = kept * drift_ + std::sqrt(1.0 - kept * kept) * options_.drift * draw();
  GlobalPosition fix;
  fix.antenna_in_base = options_.antenna_in_base;
  fix.position_in_map = world_from_base * options_.antenna_in_base + drift_ + options_.noise * draw();
  const double variance = options_.noise * options_.noise + options_.drift * options_.drift;
  fix.covariance.diagonal().head<3>() = variance * kAxes.cwiseAbs2();
  if (random_.chance(options_.outlier_rate)) {
    const double direction = random_.uniform(-kPi, kPi);
    fix.position_in_map +=
        options_.outlier_size * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
  }
  return fix;
}

RangeReceiver::RangeReceiver(const BeaconOptions& options, RandomStream random)
    : options_(options), random_(random) {}

std::vector<BeaconRange> RangeReceiver::read(const Eigen::Isometry3d& world_from_base) {
  const Eigen::Vector3d receiver = world_from_base * options_.receiver_in_base;
  std::vector<BeaconRange> ranges;
  for (const auto& [id, place] : options_.places_in_world) {
    const double distance = (place - receiver).norm();
    if (distance > options_.max_range) continue;
    double range = distance + options_.noise * random_.normal();
    if (random_.chance(options_.outlier_rate)) range += random_.uniform(0.0, options_.outlier_size);
    ranges.push_back({id, std::max(range, 0.0), options_.noise * options_.noise, options_.receiver_in_base});
  }
  return ranges;
}

}  // namespace kinect_ekf_slam
