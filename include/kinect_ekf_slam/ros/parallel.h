#pragma once

#include <cstddef>
#include <functional>

namespace kinect_ekf_slam {

/// Calls `work(i)` for i from 0 to count - 1, on all cores. `on_progress` gets the share done, 0 to 1, from
/// the calling thread; it may be empty. What `work` throws ends the others after their present call, and is
/// thrown on.
void parallel_for(std::size_t count, const std::function<void(double)>& on_progress,
                  const std::function<void(std::size_t)>& work);

}  // namespace kinect_ekf_slam
