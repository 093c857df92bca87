#pragma once

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/simulator.h"

namespace kinect_ekf_slam::testing {

/// A large room without landmarks, a robot at its middle that looks along x, sensors without any error.
inline World exact_world() {
  World world;
  world.room_size = {20.0, 20.0, 0.0};
  world.drive.world_from_start = Se2(10.0, 10.0, 0.0);
  world.drive.standing_time = 0.0;
  world.wheels.scale_sigma = 0.0;
  world.wheels.noise = 0.0;
  world.wheels.slips_per_minute = 0.0;
  world.gyro.noise = 0.0;
  world.gyro.scale_sigma = 0.0;
  world.gyro.bias_sigma = 0.0;
  world.gyro.bias_walk = 0.0;
  world.sensor.noise_scale = 0.0;
  world.sensor.radius_noise = 0.0;
  world.sensor.miss_rate = 0.0;
  world.sensor.base_from_optical.linear() =
      (Eigen::Matrix3d() << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0).finished();
  return world;
}

/// A cylinder `forward` and `left` of the robot's start in exact_world().
inline WorldLandmark cylinder(int id, double forward, double left, double radius = 0.05) {
  return {id, id % 2 == 0 ? "red" : "blue", {10.0 + forward, 10.0 + left, 0.0}, radius};
}

/// Samples until `seconds`.
inline std::vector<Sample> run(const World& world, std::uint64_t seed, double seconds) {
  Simulator simulator(world, seed);
  std::vector<Sample> samples;
  for (Sample sample = simulator.next(); to_seconds(sample.stamp) <= seconds; sample = simulator.next()) {
    samples.push_back(sample);
  }
  return samples;
}

/// All sightings of `frames` pictures, taken by a robot that stands.
inline std::vector<std::vector<Sighting>> pictures(World world, std::uint64_t seed, int frames) {
  world.wheels.rate = world.gyro.rate = 1.0;  // these do not matter
  Simulator simulator(world, seed);
  std::vector<std::vector<Sighting>> pictures;
  while (static_cast<int>(pictures.size()) < frames) {
    if (const Sample sample = simulator.next(); sample.sightings) pictures.push_back(*sample.sightings);
  }
  return pictures;
}

}  // namespace kinect_ekf_slam::testing
