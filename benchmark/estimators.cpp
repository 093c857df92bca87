#include <malloc.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "benchmark/benchmarks.h"
#include "benchmark/drive.h"
#include "benchmark/step_times.h"
#include "kinect_ekf_slam/estimators/factory.h"

namespace kinect_ekf_slam::benchmarks {
namespace {

using Type = EstimatorOptions::Type;

AssociationOptions known_identities() {
  AssociationOptions association;
  association.type = AssociationOptions::Type::kKnown;
  association.gate_probability = 0.999999;
  return association;
}

EstimatorOptions options_of(Type type, int landmarks) {
  EstimatorOptions options;
  options.type = type;
  options.max_landmarks = landmarks;
  return options;
}

template <class Space>
std::unique_ptr<SlamEstimator<Space>> make(Type type, int landmarks) {
  return make_estimator<Space>(options_of(type, landmarks), known_identities(), {});
}

template <class Space>
void follow(const std::vector<Look<Space>>& looks, SlamEstimator<Space>* estimator) {
  TimeNs stamp = 0;
  for (const auto& look : looks) {
    estimator->predict(look.motion);
    estimator->observe(++stamp, look.observations());
  }
}

/// Particles map the world themselves: to draw them from the covariance of a large map takes its Cholesky
/// factor.
template <class Space>
std::unique_ptr<SlamEstimator<Space>> make_with_map(Type type, Drive<Space>* drive) {
  auto estimator = make<Space>(type, drive->landmark_count());
  if (type == Type::kFastSlam1 || type == Type::kFastSlam2) {
    follow(survey<Space>(drive->landmark_count()), estimator.get());
  } else {
    estimator->restore(drive->known_map());
  }
  return estimator;
}

int matched(const UpdateReport& report) {
  int count = 0;
  for (const Assignment& assignment : report.assignments) count += assignment.verdict == Verdict::kMatched;
  return count;
}

template <class Space>
void update(benchmark::State& state, Type type) {
  Drive<Space> drive(static_cast<int>(state.range(0)));
  const auto estimator = make_with_map(type, &drive);
  StepTimes times;
  TimeNs stamp = 100000000000;  // ns
  std::int64_t matches = 0;
  const auto step = [&](const auto& measure) {
    const Look<Space> look = drive.next();
    const auto observations = look.observations();
    stamp += 100000000;  // ns
    measure([&] {
      estimator->predict(look.motion);
      matches += matched(estimator->observe(stamp, observations));
    });
  };
  step([](const auto& work) { work(); });  // the first one sets up what the others keep
  matches = 0;
  for (auto _ : state) {
    step([&](const auto& work) { times.measure(state, work); });
  }
  times.report(state);
  state.counters["matched"] = static_cast<double>(matches) / static_cast<double>(state.iterations());
}

/// A map of so many landmarks from nothing, eight a view.
void insert(benchmark::State& state, Type type) {
  const int landmarks = static_cast<int>(state.range(0));
  const auto looks = survey<Planar>(landmarks);
  StepTimes times;
  for (auto _ : state) {
    const auto estimator = make<Planar>(type, landmarks);
    times.measure(state, [&] { follow(looks, estimator.get()); });
    if (static_cast<int>(estimator->landmarks().size()) != landmarks)
      state.SkipWithError("landmarks are missing");
  }
  times.report(state);
}

/// Eight sightings without identity and a map: who is who by nearest neighbour, and no more.
void associate(benchmark::State& state, Type type) {
  Drive<Planar> drive(static_cast<int>(state.range(0)));
  AssociationOptions association;
  association.type = AssociationOptions::Type::kNearestNeighbor;
  const auto associator = make_associator<Planar>(association);
  const auto filter = make_kalman<Planar>(options_of(type, drive.landmark_count()), association, {});
  filter->restore(drive.known_map());
  const Look<Planar> look = drive.next();
  filter->predict(look.motion);
  const auto observations = look.observations();
  StepTimes times;
  for (auto _ : state) {
    times.measure(state, [&] {
      benchmark::DoNotOptimize(associator->associate(observations, filter->expect(observations)));
    });
  }
  times.report(state);
}

/// What the program holds of the heap, byte.
double allocated() {
  const auto heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd);
}

void memory(benchmark::State& state, Type type) {
  const int landmarks = static_cast<int>(state.range(0));
  for (auto _ : state) {
    const auto looks = survey<Planar>(landmarks);
    const auto estimator = make<Planar>(type, landmarks);
    const double before = allocated();
    follow(looks, estimator.get());
    state.counters["kB_per_landmark"] = (allocated() - before) / 1024.0 / landmarks;
    state.SetIterationTime(1e-9);
  }
}

}  // namespace

void register_estimators() {
  const auto add = [](const std::string& name, const auto& function, auto type, int landmarks,
                      int iterations) {
    benchmark::RegisterBenchmark(name.c_str(), function, type)
        ->Arg(landmarks)
        ->Iterations(iterations)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  for (const int n : {50, 100, 200, 500, 1000, 2000}) {
    const int steps = n < 1000 ? 300 : 60;
    add("update/ekf", update<Planar>, Type::kEkf, n, steps);
    add("update/invariant_ekf", update<Planar>, Type::kInvariantEkf, n, steps);
    add("update/ukf", update<Planar>, Type::kUkf, n, steps);
    if (n <= 1000) add("spatial/ekf", update<Spatial>, Type::kEkf, n, steps);
    if (n <= 1000) add("spatial/invariant_ekf", update<Spatial>, Type::kInvariantEkf, n, steps);
    add("associate/ekf", associate, Type::kEkf, n, 100);
  }
  for (const int n : {100, 500, 1000, 2000, 5000, 10000}) {
    add("update/compressed_ekf", update<Planar>, Type::kCompressedEkf, n, n <= 2000 ? 3000 : 600);
    add("associate/compressed_ekf", associate, Type::kCompressedEkf, n, 100);
  }
  for (const int n : {50, 100, 200, 500, 1000, 2000, 10000}) {
    add("update/fastslam1", update<Planar>, Type::kFastSlam1, n, 100);
    add("update/fastslam2", update<Planar>, Type::kFastSlam2, n, 100);
  }
  add("insert/ekf", insert, Type::kEkf, 2000, 3);
  add("insert/invariant_ekf", insert, Type::kInvariantEkf, 2000, 3);
  for (const auto& [name, type, meaning] : kEstimators) {
    if (type != Type::kDeadReckoning) add(std::string("memory/") + name, memory, type, 1000, 1);
  }
}

}  // namespace kinect_ekf_slam::benchmarks
