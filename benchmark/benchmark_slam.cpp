// Time per update, association, insertion and memory over the number of landmarks; see scripts/benchmark.sh.
#include <benchmark/benchmark.h>

#include "benchmark/benchmarks.h"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  kinect_ekf_slam::benchmarks::register_limits();
  kinect_ekf_slam::benchmarks::register_estimators();
  kinect_ekf_slam::benchmarks::register_mrpt();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
