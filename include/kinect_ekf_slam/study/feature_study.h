#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "kinect_ekf_slam/perception/feature.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// A simulated robot on its way through a world with patterns, and the detector of natural features.
struct FeatureStudy {
  World world;
  FeatureOptions detector;
  std::uint64_t seed = 1;
  int pictures = 150;
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

struct FeatureStudyResult {
  int pictures = 0;
  int tracks = 0;               ///< numbers that were reported
  int sightings = 0;            ///< features that were reported, over all pictures
  int again = 0;                ///< of those, such whose number had been reported before
  int elsewhere = 0;            ///< of these, such that are not where the number was first
  double difference_rms = 0.0;  ///< m, of the place in the world, to where the number was first
  double milliseconds = 0.0;    ///< of the detector, mean
  RgbdPicture last_picture;
  Findings last_findings;
};

FeatureStudyResult run_study(const FeatureStudy& study);

std::string to_table(const FeatureStudyResult& result);

}  // namespace kinect_ekf_slam
