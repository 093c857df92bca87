#include "kinect_ekf_slam/study/patrol_study.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "kinect_ekf_slam/pipeline/slam_pipeline.h"
#include "kinect_ekf_slam/simulation/simulator.h"
#include "kinect_ekf_slam/study/room_study.h"
#include "kinect_ekf_slam/study/text.h"
#include "kinect_ekf_slam/study/thread_time.h"

namespace kinect_ekf_slam {
namespace {

constexpr int kStretches = 12;

/// What the kernel says that this program holds; zero where there is no /proc.
double resident_megabytes() {
  std::ifstream statm("/proc/self/statm");
  double all_pages = 0.0;
  double resident_pages = 0.0;
  statm >> all_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<PatrolStretch> run_study(const PatrolStudy& study) {
  World world = study.world;
  world.drive.loops = std::numeric_limits<int>::max() / 1000;  // never finished
  Simulator simulator(world, study.seed);
  const auto pipeline = make_pipeline(study.pipeline);
  std::vector<PatrolStretch> patrol;
  std::vector<double> updates;
  while (patrol.size() < kStretches) {
    const Sample sample = simulator.next();
    const double start = thread_seconds();
    pipeline->process(to_sensor_frame(sample, world));
    if (sample.sightings) updates.push_back(1e3 * (thread_seconds() - start));
    const double minutes = to_seconds(sample.stamp) / 60.0;
    const double end =
        static_cast<double>(study.minutes) * static_cast<double>(patrol.size() + 1) / kStretches;
    if (minutes < end || updates.empty()) continue;
    const auto map = pipeline->map();
    const auto confirmed = std::count_if(map.begin(), map.end(), [](const auto& l) { return l.confirmed; });
    patrol.push_back({minutes, static_cast<std::size_t>(confirmed), resident_megabytes(), median(updates)});
    updates.clear();
    if (study.on_progress) study.on_progress(static_cast<double>(patrol.size()) / kStretches);
  }
  return patrol;
}

bool is_flat(const std::vector<PatrolStretch>& patrol) {
  const PatrolStretch& first = patrol.front();
  const PatrolStretch& last = patrol.back();
  return last.landmarks <= first.landmarks + 1 && last.megabytes <= first.megabytes + 1.0 &&
         last.update_ms <= 1.25 * first.update_ms;
}

std::string to_table(const std::vector<PatrolStretch>& patrol) {
  std::string table = format("%8s %10s %12s %16s\n", "minutes", "landmarks", "memory (MB)", "update (ms)");
  for (const PatrolStretch& stretch : patrol) {
    table += format("%8.0f %10zu %12.1f %16.3f\n", stretch.minutes, stretch.landmarks, stretch.megabytes,
                    stretch.update_ms);
  }
  return table + (is_flat(patrol) ? "flat" : "NOT flat") +
         ": from the first row to the last, at most 1 landmark, 1 MB and a quarter of the time more\n";
}

}  // namespace kinect_ekf_slam
