#include "kinect_ekf_slam/study/monte_carlo.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

#include "kinect_ekf_slam/core/chi_square.h"

namespace kinect_ekf_slam {

void for_each_run(std::size_t count, const std::function<void(std::size_t)>& run,
                  const std::function<void(double)>& on_progress) {
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> done{0};
  std::exception_ptr problem;
  std::mutex problem_mutex;
  const auto work = [&](bool reports) {
    try {
      for (std::size_t i = next++; i < count; i = next++) {
        run(i);
        ++done;
        if (reports && on_progress) on_progress(static_cast<double>(done) / static_cast<double>(count));
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(problem_mutex);
      problem = std::current_exception();
      next = count;
    }
  };
  std::vector<std::thread> threads;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  for (unsigned i = 1; i < cores; ++i) threads.emplace_back(work, false);
  work(true);
  for (std::thread& thread : threads) thread.join();
  if (problem) std::rethrow_exception(problem);
}

Consistency consistency(const std::vector<std::vector<double>>& nees, int dof) {
  const auto runs = static_cast<double>(nees.size());
  std::size_t times = nees.front().size();
  for (const std::vector<double>& run : nees) times = std::min(times, run.size());
  Consistency result;
  result.low = chi_square_quantile(0.025, dof * runs) / runs;
  result.high = chi_square_quantile(0.975, dof * runs) / runs;
  result.mean_nees.assign(times, 0.0);
  for (std::size_t time = 0; time < times; ++time) {
    for (const std::vector<double>& run : nees) result.mean_nees[time] += run[time] / runs;
    result.mean += result.mean_nees[time] / static_cast<double>(times);
  }
  const auto inside = std::count_if(result.mean_nees.begin(), result.mean_nees.end(),
                                    [&](double mean) { return result.low <= mean && mean <= result.high; });
  result.inside_share = static_cast<double>(inside) / static_cast<double>(times);
  return result;
}

}  // namespace kinect_ekf_slam
