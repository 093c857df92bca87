#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "kinect_ekf_slam/perception/fiducial.h"

namespace kinect_ekf_slam {

/// Random views of one fiducial each, 0.5 to 2.5 m away and slanted by up to 60 degrees, rendered with noise.
struct FiducialStudy {
  FiducialOptions detector;
  std::uint64_t first_seed = 1;
  int views = 1000;
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

struct FiducialStudyResult {
  int views = 0;
  int found = 0;
  int wrong_identities = 0;
  int within_one_percent = 0;       ///< of those found: position off by at most 1 % of the distance
  double relative_error_rms = 0.0;  ///< error of the position over the distance
  double relative_error_worst = 0.0;
};

FiducialStudyResult run_study(const FiducialStudy& study);

std::string to_table(const FiducialStudyResult& result);

}  // namespace kinect_ekf_slam
