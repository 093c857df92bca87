#pragma once

#include <ctime>

namespace kinect_ekf_slam {

/// Seconds of work that the calling thread has done on its core; other work on the machine does not count.
inline double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace kinect_ekf_slam
