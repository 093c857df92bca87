#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace kinect_ekf_slam {

/// Calls `run(i)` for i from 0 to count - 1 on all cores. `on_progress` (may be empty) hears the share done,
/// 0 to 1, on the calling thread. An exception of a run ends the rest and comes out here.
void for_each_run(std::size_t count, const std::function<void(std::size_t)>& run,
                  const std::function<void(double)>& on_progress);

/// Whether the covariances of many runs told the truth. NEES: e^T P^-1 e, chi-square with as many degrees of
/// freedom as the error has numbers. (Bar-Shalom, Li and Kirubarajan, section 5.4.)
struct Consistency {
  std::vector<double> mean_nees;  ///< over the runs, at each time
  double low = 0.0;  ///< where that mean lies with 95 % probability, if the estimate is consistent
  double high = 0.0;
  double inside_share = 0.0;  ///< of the times at which it lies there
  double mean = 0.0;          ///< over runs and times
};

/// `nees[run][time]`; all runs count up to the end of the shortest one. There is at least one of each.
Consistency consistency(const std::vector<std::vector<double>>& nees, int dof);

}  // namespace kinect_ekf_slam
