#pragma once

namespace kinect_ekf_slam::benchmarks {

void register_limits();      ///< what no dense filter can beat
void register_estimators();  ///< ours
void register_mrpt();        ///< MRPT's, where it is installed

}  // namespace kinect_ekf_slam::benchmarks
