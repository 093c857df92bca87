#include "kinect_ekf_slam/study/kidnapped_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/pipeline/slam_pipeline.h"
#include "kinect_ekf_slam/simulation/wanderer.h"
#include "kinect_ekf_slam/study/monte_carlo.h"
#include "kinect_ekf_slam/study/room_study.h"

namespace kinect_ekf_slam {
namespace {

/// A map, and where the truth is in it.
struct TrueMap {
  SavedState map;
  Se2 map_from_world;
};

TrueMap make_map(const KidnappedStudy& study) {
  Simulator simulator(study.world, 0);
  PipelineOptions options = study.pipeline;
  options.mode = Mode::kSlam;
  const auto pipeline = make_pipeline(options);
  while (!simulator.finished()) pipeline->process(to_sensor_frame(simulator.next(), study.world));
  TrueMap result;
  result.map = pipeline->save();
  Points<Planar> in_map;
  Points<Planar> in_world;
  for (std::size_t i = 0; i < result.map.infos.size(); ++i) {
    for (const WorldLandmark& landmark : study.world.landmarks) {
      if (landmark.id != result.map.infos[i].source_id) continue;
      in_map.emplace_back(result.map.landmarks_in_map.row(static_cast<Eigen::Index>(i)).head<2>());
      in_world.emplace_back(landmark.position_in_world.head<2>());
    }
  }
  if (in_map.size() < 3) throw std::runtime_error("the map to be lost in has fewer than three landmarks");
  result.map_from_world = align<Planar>(in_map, in_world);
  if (study.looks) return result;
  for (LandmarkInfo& info : result.map.infos) {
    info.label_votes.clear();
    info.radius = 0.0;
  }
  return result;
}

/// Somewhere in the room where a robot can stand, turned anyhow.
Se2 random_pose(const World& world, RandomStream* random) {
  constexpr double kMargin = 0.1;  // m
  const double radius = world.drive.robot_radius + kMargin;
  while (true) {
    const double x = random->uniform(radius, world.room_size.x() - radius);
    const double y = random->uniform(radius, world.room_size.y() - radius);
    const double yaw = random->uniform(-kPi, kPi);
    const bool is_free =
        std::all_of(world.landmarks.begin(), world.landmarks.end(), [&](const WorldLandmark& landmark) {
          return (landmark.position_in_world.head<2>() - Eigen::Vector2d(x, y)).norm() >
                 radius + landmark.radius;
        });
    if (is_free) return {x, y, yaw};
  }
}

KidnappedRun run_robot(const KidnappedStudy& study, const TrueMap& truth, std::uint64_t seed) {
  constexpr std::uint32_t kPlaceStream = 100;  // none of the simulator's
  RandomStream random(seed, kPlaceStream);
  World world = study.world;
  world.drive.world_from_start = RobotPose(random_pose(world, &random));
  Simulator simulator(world, seed);
  Wanderer wanderer(seed);
  PipelineOptions options = study.pipeline;
  options.mode = Mode::kLocalization;
  const auto pipeline = make_pipeline(options);
  pipeline->load(truth.map, false);
  pipeline->relocalize();

  KidnappedRun run;
  run.seed = seed;
  while (run.seconds < study.patience) {
    const Sample sample = simulator.next();
    if (sample.odometry) simulator.set_command(wanderer.command(sample.stamp, sample.odometry->velocity));
    SensorFrame frame = to_sensor_frame(sample, world);
    if (frame.detections && !study.looks) {
      for (Detection& detection : *frame.detections) detection.signature = {};
    }
    const SlamResult result = pipeline->process(frame);
    run.seconds = to_seconds(sample.stamp);
    if (result.localization != Localization::kFound) continue;
    const Se2 map_from_base = truth.map_from_world * Planar::pose_from_3d(sample.world_from_base);
    const Se2 estimate = Planar::pose_from_3d(result.pose.map_from_base);
    run.found = true;
    run.position_error = (estimate.translation() - map_from_base.translation()).norm();
    run.heading_error = std::abs(wrap_angle(estimate.angle() - map_from_base.angle()));
    break;
  }
  return run;
}

template <class Figure>
std::string spread(const char* name, const std::vector<KidnappedRun>& runs, const Figure& figure) {
  std::vector<double> values;
  for (const KidnappedRun& run : runs) {
    if (run.found) values.push_back(figure(run));
  }
  if (values.empty()) return "";
  std::sort(values.begin(), values.end());
  char line[160];
  std::snprintf(line, sizeof(line), "  %-28s median %7.3f, largest %7.3f\n", name, values[values.size() / 2],
                values.back());
  return line;
}

}  // namespace

bool KidnappedRun::is_right() const {
  constexpr double kPosition = 0.1;  // m
  return found && position_error <= kPosition && heading_error <= radians(5.0);
}

std::vector<KidnappedRun> run_study(const KidnappedStudy& study) {
  const TrueMap truth = make_map(study);
  std::vector<KidnappedRun> runs(static_cast<std::size_t>(study.robots));
  for_each_run(
      runs.size(), [&](std::size_t i) { runs[i] = run_robot(study, truth, study.first_seed + i); },
      study.on_progress);
  return runs;
}

std::string to_table(const std::string& title, const std::vector<KidnappedRun>& runs) {
  const auto right = std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.is_right(); });
  const auto wrong =
      std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.found && !run.is_right(); });
  char line[240];
  std::snprintf(line, sizeof(line),
                "%zu robots, %s: %td found to 0.1 m and 5 deg, %td said so wrongly, %td still searching\n",
                runs.size(), title.c_str(), right, wrong,
                static_cast<std::ptrdiff_t>(runs.size()) - right - wrong);
  return line + spread("seconds until found", runs, [](const auto& run) { return run.seconds; }) +
         spread("position error (m)", runs, [](const auto& run) { return run.position_error; }) +
         spread("heading error (deg)", runs, [](const auto& run) { return degrees(run.heading_error); });
}

}  // namespace kinect_ekf_slam
