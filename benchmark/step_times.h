#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "kinect_ekf_slam/study/thread_time.h"

namespace kinect_ekf_slam::benchmarks {

/// Times of single steps, in seconds of the thread: Google Benchmark itself tells their mean only.
class StepTimes {
 public:
  template <class Work>
  void measure(benchmark::State& state, const Work& work) {
    const double start = thread_seconds();
    work();
    times_.push_back(thread_seconds() - start);
    state.SetIterationTime(times_.back());
  }
  /// Counters of the run, in milliseconds.
  void report(benchmark::State& state) {
    std::sort(times_.begin(), times_.end());
    state.counters["median_ms"] = quantile(0.5);
    state.counters["p999_ms"] = quantile(0.999);
    state.counters["max_ms"] = quantile(1.0);
  }

 private:
  double quantile(double share) const {
    return 1e3 * times_[static_cast<std::size_t>(share * static_cast<double>(times_.size() - 1))];
  }

  std::vector<double> times_;
};

}  // namespace kinect_ekf_slam::benchmarks
