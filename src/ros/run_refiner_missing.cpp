#include <stdexcept>

#include "kinect_ekf_slam/ros/run_refiner.h"

namespace kinect_ekf_slam {

void require_refining(const RunOptions& /*options*/) {
  throw std::runtime_error(
      "--refine: this build is without Ceres 2.1 or later; install libceres-dev and build again");
}

RefinementReport refine_run(const FinishedRun& /*run*/, const RunOptions& options,
                            const std::string& /*directory*/,
                            const std::function<void(double)>& /*on_progress*/) {
  require_refining(options);
  return {};
}

}  // namespace kinect_ekf_slam
