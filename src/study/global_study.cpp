#include "kinect_ekf_slam/study/global_study.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kinect_ekf_slam/fusion/interpolation.h"
#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "kinect_ekf_slam/study/text.h"

namespace kinect_ekf_slam {
namespace {

using Positions = std::vector<Stamped<Gaussian<3>>>;

AssociationOptions association() {
  AssociationOptions options;
  options.type = AssociationOptions::Type::kJointCompatibility;  // identities are not used
  return options;
}

std::unique_ptr<LocalMaps<Spatial>> make_slam_of(const BuoyWorld& world) {
  const EstimatorOptions estimator;  // as shipped: what is taken for a neighbour now and then pulls little
  LocalMapOptions local_maps;
  local_maps.min_matches = 2;
  local_maps.max_position_sigma = 0.5;
  local_maps.path_interval = 2.0;
  PoseEstimate<Spatial> start;
  start.map_from_base = world.true_pose(0);
  start.covariance.diagonal().setConstant(1e-8);
  return make_local_maps<Spatial>(estimator, association(), {}, local_maps, start);
}

/// Everything that one run of the two sensors produced.
struct Recording {
  std::vector<LocalMap<Spatial>> local_maps;
  std::vector<Eigen::Vector3d> slam_path;            ///< at each step from 1
  Positions beacon_path;                             ///< the buoys' filter
  std::vector<Stamped<GlobalPlace<Spatial>>> fixes;  ///< of the buoys, independent of each other
};

/// Algorithm 3, lines 1 to 15: the two sensors, each by itself.
Recording record(const BuoyWorld& truth) {
  BuoyWorld world = truth;
  Recording recording;
  const auto slam = make_slam_of(world);
  BeaconLocalizationOptions options;
  options.acceleration_noise = 0.05;
  const Gaussian<3> start{world.true_pose(0).translation(), 4.0 * Eigen::Matrix3d::Identity()};
  BeaconLocalization<Spatial> buoys(world.beacons(), options, 0, start);
  for (int step = 1; step <= world.steps(); ++step) {
    const TimeNs stamp = world.stamp(step);
    slam->predict(world.drive(step));
    slam->observe(stamp, world.look(step));
    recording.slam_path.push_back(slam->pose().map_from_base.translation());
    const std::vector<BeaconRange> ranges = world.listen(step);
    if (ranges.empty()) continue;
    const auto report = buoys.update(stamp, ranges);
    recording.beacon_path.push_back({stamp, buoys.position()});
    if (!report.fix) continue;
    GlobalPlace<Spatial> place;
    place.antenna = *report.fix;
    recording.fixes.push_back({stamp, place});
  }
  recording.local_maps = slam->maps();
  return recording;
}

double squared(double value) { return value * value; }

/// The buoys' position at a time between, from the three around it.
Eigen::Vector3d interpolated(const Positions& path, TimeNs stamp) {
  const auto after = std::lower_bound(path.begin(), path.end(), stamp, [](const auto& position, TimeNs time) {
    return position.stamp < time;
  });
  const auto index =
      std::clamp<std::ptrdiff_t>(after - path.begin() - 1, 0, static_cast<std::ptrdiff_t>(path.size()) - 3);
  return interpolate<3>({path.begin() + index, path.begin() + index + 3}, stamp).mean;
}

double rms(double squares, double count) { return count > 0.0 ? std::sqrt(squares / count) : std::nan(""); }

void judge_single_sensors(const BuoyWorld& world, const Recording& recording, GlobalRun* run) {
  double slam = 0.0;
  double beacons = 0.0;
  double covered = 0.0;
  for (int step = 1; step <= world.steps(); ++step) {
    const Eigen::Vector3d truth = world.true_pose(step).translation();
    slam += (recording.slam_path[static_cast<std::size_t>(step - 1)] - truth).squaredNorm();
    const TimeNs stamp = world.stamp(step);
    if (stamp < recording.beacon_path.front().stamp || stamp > recording.beacon_path.back().stamp) continue;
    beacons += (interpolated(recording.beacon_path, stamp) - truth).squaredNorm();
    covered += 1.0;
  }
  run->slam_path_rmse = rms(slam, world.steps());
  run->beacon_path_rmse = rms(beacons, covered);

  double landmarks = 0.0;
  double count = 0.0;
  Se3 world_from_local = world.true_pose(0);
  for (const LocalMap<Spatial>& map : recording.local_maps) {
    for (std::size_t i = 0; i < map.state.infos.size(); ++i) {
      if (is_path_point(map.state.infos[i])) continue;
      const Eigen::Vector3d point = map.state.landmarks_in_map.segment<3>(3 * static_cast<Eigen::Index>(i));
      const auto identity = static_cast<std::size_t>(map.state.infos[i].source_id);
      landmarks += (world_from_local * point - world.landmarks()[identity]).squaredNorm();
      count += 1.0;
    }
    world_from_local = world_from_local * map.state.map_from_base;
  }
  run->slam_landmark_rmse = rms(landmarks, count);
}

void judge_path(const BuoyWorld& world, const GlobalMap<Spatial>& map, double rate, GlobalRun* run) {
  double squares = 0.0;
  double count = 0.0;
  for (const GlobalSegment<Spatial>& segment : map.segments) {
    for (const auto& pose : segment.path) {
      const auto step = static_cast<int>(std::lround(to_seconds(pose.stamp) * rate));
      const Eigen::Vector3d error =
          pose.value.map_from_base.translation() - world.true_pose(step).translation();
      squares += error.squaredNorm();
      count += 1.0;
      if (step % static_cast<int>(rate) != 0 ||
          run->path_nees.size() >= static_cast<std::size_t>(step / rate)) {
        continue;  // between the seconds, or the first pose of a segment, which the last one's end has told
      }
      const Eigen::Matrix3d covariance = pose.value.covariance.topLeftCorner<3, 3>();
      run->path_nees.push_back(error.dot(covariance.llt().solve(error)));
    }
  }
  run->path_rmse = rms(squares, count);
}

void judge_landmarks(const BuoyWorld& world, const GlobalMap<Spatial>& map, GlobalRun* run) {
  double squares = 0.0;
  run->landmark_nees.assign(world.landmarks().size(), std::nan(""));
  for (const LandmarkEstimate<Spatial>& landmark : map.landmarks) {
    const auto identity = static_cast<std::size_t>(landmark.info.source_id);
    const Eigen::Vector3d error = landmark.position_in_map - world.landmarks()[identity];
    squares += error.squaredNorm();
    run->landmark_nees[identity] = error.dot(landmark.covariance.llt().solve(error));
  }
  run->landmark_rmse = rms(squares, static_cast<double>(map.landmarks.size()));
}

std::vector<double> row(const Eigen::Vector3d& point) { return {point.x(), point.y(), point.z()}; }

GlobalExample example_of(const BuoyWorld& world, const Recording& recording, const GlobalMap<Spatial>& map) {
  GlobalExample example;
  for (int step = 1; step <= world.steps(); ++step) {
    example.truth.push_back(row(world.true_pose(step).translation()));
    example.slam.push_back(row(recording.slam_path[static_cast<std::size_t>(step - 1)]));
  }
  for (const auto& position : recording.beacon_path) example.beacons.push_back(row(position.value.mean));
  for (const auto& fix : recording.fixes) example.global_positions.push_back(row(fix.value.antenna.mean));
  for (const auto& landmark : map.landmarks) example.landmarks.push_back(row(landmark.position_in_map));
  for (const auto& landmark : world.landmarks()) example.true_landmarks.push_back(row(landmark));
  for (const auto& segment : map.segments) {
    example.segments.emplace_back();
    for (const auto& pose : segment.path) {
      example.segments.back().push_back(row(pose.value.map_from_base.translation()));
    }
  }
  return example;
}

GlobalRun run_once(const BuoyScenario& scenario, std::uint64_t seed, GlobalExample* example) {
  const BuoyWorld world(scenario, seed);
  const Recording recording = record(world);
  GlobalMapOptions options;
  options.association = association();
  const GlobalMap<Spatial> map = integrate_maps<Spatial>(recording.local_maps, recording.fixes, options);
  GlobalRun run;
  run.local_maps = recording.local_maps.size();
  run.merged_landmarks = map.merged_landmarks;
  for (const GlobalSegment<Spatial>& segment : map.segments) {
    run.joined += static_cast<std::size_t>(segment.last_map - segment.first_map);
    if (!segment.refusal.empty()) ++run.unplaced;
    run.disagreements += segment.disagreements.size();
  }
  judge_single_sensors(world, recording, &run);
  judge_path(world, map, scenario.rate, &run);
  judge_landmarks(world, map, &run);
  if (example != nullptr) *example = example_of(world, recording, map);
  return run;
}

double root_mean_square(const std::vector<GlobalRun>& runs, double GlobalRun::*figure) {
  double squares = 0.0;
  for (const GlobalRun& run : runs) squares += squared(run.*figure);
  return rms(squares, static_cast<double>(runs.size()));
}

/// Of the landmarks that are in the map of every run.
std::vector<std::vector<double>> common_nees(const std::vector<GlobalRun>& runs) {
  std::vector<std::vector<double>> common(runs.size());
  for (std::size_t i = 0; i < runs.front().landmark_nees.size(); ++i) {
    const bool is_in_all = std::all_of(
        runs.begin(), runs.end(), [&](const GlobalRun& run) { return std::isfinite(run.landmark_nees[i]); });
    for (std::size_t k = 0; k < runs.size() && is_in_all; ++k) common[k].push_back(runs[k].landmark_nees[i]);
  }
  return common;
}

}  // namespace

GlobalSummary run_study(const GlobalStudy& study, GlobalExample* example) {
  GlobalSummary summary;
  summary.runs.resize(static_cast<std::size_t>(study.seeds));
  for_each_run(
      summary.runs.size(),
      [&](std::size_t i) { summary.runs[i] = run_once(study.scenario, i + 1, i == 0 ? example : nullptr); },
      study.on_progress);
  summary.path_rmse = root_mean_square(summary.runs, &GlobalRun::path_rmse);
  summary.landmark_rmse = root_mean_square(summary.runs, &GlobalRun::landmark_rmse);
  summary.slam_path_rmse = root_mean_square(summary.runs, &GlobalRun::slam_path_rmse);
  summary.slam_landmark_rmse = root_mean_square(summary.runs, &GlobalRun::slam_landmark_rmse);
  summary.beacon_path_rmse = root_mean_square(summary.runs, &GlobalRun::beacon_path_rmse);
  std::vector<std::vector<double>> path_nees;
  for (const GlobalRun& run : summary.runs) path_nees.push_back(run.path_nees);
  summary.path = consistency(path_nees, 3);
  summary.landmarks = consistency(common_nees(summary.runs), 3);
  return summary;
}

std::string to_table(const GlobalSummary& summary) {
  std::string table = format("%-28s %10s %15s\n", "RMSE", "path (m)", "landmarks (m)");
  table += format("%-28s %10.3f %15.3f\n", "SLAM alone, start known", summary.slam_path_rmse,
                  summary.slam_landmark_rmse);
  table += format("%-28s %10.3f %15s\n", "buoys alone", summary.beacon_path_rmse, "-");
  table += format("%-28s %10.3f %15.3f\n", "global map", summary.path_rmse, summary.landmark_rmse);
  const double better = std::min(summary.slam_path_rmse, summary.beacon_path_rmse);
  table += format("global map over the better single sensor: path %.2f, landmarks %.2f\n",
                  summary.path_rmse / better, summary.landmark_rmse / summary.slam_landmark_rmse);
  for (const auto& [name, nees] :
       {std::pair("path", &summary.path), std::pair("landmarks", &summary.landmarks)}) {
    table += format("NEES of the %s: mean %.2f, %.0f %% inside the 95 %% bounds %.2f to %.2f\n", name,
                    nees->mean, 100.0 * nees->inside_share, nees->low, nees->high);
  }
  double maps = 0.0;
  double joined = 0.0;
  double merged = 0.0;
  double left_out = 0.0;
  double unplaced = 0.0;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  const auto count = static_cast<double>(summary.runs.size());
  for (const GlobalRun& run : summary.runs) {
    fewest = std::min(fewest, run.local_maps);
    maps += static_cast<double>(run.local_maps) / count;
    joined += static_cast<double>(run.joined) / count;
    merged += run.merged_landmarks / count;
    left_out += static_cast<double>(run.disagreements) / count;
    unplaced += static_cast<double>(run.unplaced) / count;
  }
  return table +
         format("a run: %.1f local maps (at least %zu), %.1f joined with a neighbour, %.1f not placed, ",
                maps, fewest, joined, unplaced) +
         format("%.1f landmarks of several maps merged, %.1f positions left out\n", merged, left_out);
}

std::string to_json(const GlobalSummary& summary, const GlobalExample& example) {
  std::string runs;
  for (const GlobalRun& run : summary.runs) {
    runs += std::string(runs.empty() ? "" : ",\n  ") + "{\"local_maps\": " + std::to_string(run.local_maps) +
            ", \"joined\": " + std::to_string(run.joined) +
            ", \"unplaced\": " + std::to_string(run.unplaced) +
            ", \"merged_landmarks\": " + std::to_string(run.merged_landmarks) +
            ", \"path_rmse_m\": " + number(run.path_rmse) +
            ", \"landmark_rmse_m\": " + number(run.landmark_rmse) +
            ", \"slam_path_rmse_m\": " + number(run.slam_path_rmse) +
            ", \"slam_landmark_rmse_m\": " + number(run.slam_landmark_rmse) +
            ", \"beacon_path_rmse_m\": " + number(run.beacon_path_rmse) + "}";
  }
  return "{\"path_rmse_m\": " + number(summary.path_rmse) +
         ", \"landmark_rmse_m\": " + number(summary.landmark_rmse) +
         ", \"slam_path_rmse_m\": " + number(summary.slam_path_rmse) +
         ", \"slam_landmark_rmse_m\": " + number(summary.slam_landmark_rmse) +
         ", \"beacon_path_rmse_m\": " + number(summary.beacon_path_rmse) +
         ",\n \"path_nees\": " + number(summary.path.mean) +
         ", \"landmark_nees\": " + number(summary.landmarks.mean) +
         ", \"nees_bounds\": " + json(std::vector<double>{summary.path.low, summary.path.high}) +
         ", \"path_nees_over_time\": " + json(summary.path.mean_nees) + ",\n \"runs\": [\n  " + runs +
         "],\n \"example\": {\"truth\": " + json(example.truth) + ",\n  \"slam\": " + json(example.slam) +
         ",\n  \"beacons\": " + json(example.beacons) +
         ",\n  \"global_positions\": " + json(example.global_positions) +
         ",\n  \"landmarks\": " + json(example.landmarks) +
         ",\n  \"true_landmarks\": " + json(example.true_landmarks) +
         ",\n  \"segments\": " + json(example.segments) + "}}\n";
}

}  // namespace kinect_ekf_slam
