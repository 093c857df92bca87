#include "kinect_ekf_slam/study/room_study.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "kinect_ekf_slam/pipeline/frame_buffer.h"
#include "kinect_ekf_slam/pipeline/slam_pipeline.h"
#include "kinect_ekf_slam/study/monte_carlo.h"
#include "kinect_ekf_slam/study/simulated_picture.h"
#include "kinect_ekf_slam/study/text.h"

namespace kinect_ekf_slam {
namespace {

/// e^T P^-1 e of the pose, the error as the estimators mean it.
template <class Space>
double pose_nees(const Pose3d& estimate, const typename Space::Pose& truth) {
  const PoseEstimate<Space> pose = to_estimate<Space>(estimate);
  const typename Space::PoseVector error = pose_error<Space>(truth, pose.map_from_base);
  return error.dot(pose.covariance.ldlt().solve(error));
}

/// What the map is sure of.
std::vector<Landmark3d> confirmed(std::vector<Landmark3d> map) {
  map.erase(std::remove_if(map.begin(), map.end(), [](const Landmark3d& l) { return !l.confirmed; }),
            map.end());
  return map;
}

template <class Space>
MapComparison compare(const World& world, const std::vector<Landmark3d>& map) {
  const Eigen::Isometry3d start_from_world = world.drive.world_from_start.to_3d().inverse();
  Points<Space> truth;
  Points<Space> estimate;
  for (const WorldLandmark& landmark : world.landmarks) {
    truth.push_back(Space::from_3d(start_from_world * landmark.position_in_world));
  }
  for (const Landmark3d& landmark : map) estimate.push_back(Space::from_3d(landmark.position_in_map));
  return compare_maps<Space>(truth, estimate);
}

int count_wrong_labels(const World& world, const std::vector<Landmark3d>& map,
                       const MapComparison& comparison) {
  const auto& pairs = comparison.pairs;
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return world.landmarks[pair.first].label != map[pair.second].label;
  }));
}

/// What the robot sees: the simulated sightings, or what a detector finds in pictures.
class Eyes {
 public:
  Eyes(const RoomStudy& study, std::uint64_t seed) : world_(study.world) {
    if (!study.make_detector) return;
    find_ = study.make_detector();
    camera_.emplace(study.world, seed);
  }

  SensorFrame look(const Sample& sample) {
    SensorFrame frame = to_sensor_frame(sample, world_);
    if (!find_) return frame;
    frame.detections.reset();
    if (sample.takes_picture) {
      const Eigen::Isometry3d& base_from_optical = world_.sensor.base_from_optical;
      const Eigen::Vector3d up_in_optical = base_from_optical.linear().row(2);
      const Findings findings = find_(camera_->take(sample.world_from_base), up_in_optical);
      frame.detections = to_detections(findings, base_from_optical);
    }
    return frame;
  }

 private:
  const World& world_;
  FindInPicture find_;
  std::optional<SimulatedCamera> camera_;
};

/// The frames of a simulation in the order of their stamps, those of wheels and gyro stamped late.
class LateOdometry {
 public:
  explicit LateOdometry(double delay)
      : delay_(to_nanoseconds(delay)), buffer_(delay + kPatience, kMostFrames) {}

  /// What is due; a frame with detections is due at once.
  std::vector<SensorFrame> add(SensorFrame frame) {
    SensorFrame moving = frame;
    moving.stamp += delay_;
    moving.detections.reset();
    std::vector<SensorFrame> due = buffer_.add(std::move(moving));
    if (!frame.detections) return due;
    frame.odometry.reset();
    frame.gyro_rate.reset();
    for (SensorFrame& released : buffer_.add(std::move(frame))) due.push_back(std::move(released));
    return due;
  }

 private:
  static constexpr double kPatience = 1.0;  // s
  static constexpr std::size_t kMostFrames = 100000;
  TimeNs delay_;
  FrameBuffer buffer_;
};

template <class Space>
RoomRun run_room_in(const RoomStudy& study, std::uint64_t seed) {
  Simulator simulator(study.world, seed);
  Eyes eyes(study, seed);
  const auto pipeline = make_pipeline(study.pipeline);
  const Eigen::Isometry3d start_from_world = study.world.drive.world_from_start.to_3d().inverse();
  RoomRun run;
  run.seed = seed;
  run.pose_dof = Space::kPoseDim;
  double squared_errors = 0.0;
  LateOdometry frames(study.odometry_delay);
  while (!simulator.finished()) {
    const Sample sample = simulator.next();
    SlamResult result;
    for (const SensorFrame& frame : frames.add(eyes.look(sample))) result = pipeline->process(frame);
    run.seconds = to_seconds(sample.stamp);
    run.said_lost = run.said_lost || result.localization == Localization::kLost;
    if (!result.looked || run.seconds <= study.world.drive.standing_time) continue;
    const typename Space::Pose truth = Space::pose_from_3d(start_from_world * sample.world_from_base);
    const typename Space::Pose estimate = Space::pose_from_3d(result.pose.map_from_base);
    squared_errors += (estimate.translation() - truth.translation()).squaredNorm();
    run.nees.push_back(pose_nees<Space>(result.pose, truth));
    run.nees_mean += run.nees.back();
  }
  const auto count = static_cast<double>(run.nees.size());
  run.path_rmse = std::sqrt(squared_errors / count);
  run.nees_mean /= count;
  const std::vector<Landmark3d> map = confirmed(pipeline->map());
  run.map = compare<Space>(study.world, map);
  run.wrong_labels = count_wrong_labels(study.world, map, run.map);
  return run;
}

template <class Figure>
Spread spread(const std::vector<RoomRun>& runs, const Figure& figure) {
  std::vector<double> values;
  for (const RoomRun& run : runs) {
    const auto value = static_cast<double>(figure(run));
    values.push_back(std::isnan(value) ? std::numeric_limits<double>::infinity() : value);  // nothing matched
  }
  std::sort(values.begin(), values.end());
  Spread result;
  for (const double value : values) result.mean += value / static_cast<double>(values.size());
  result.median = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  result.worst = values.back();
  return result;
}

std::string json(const Spread& spread) {
  return "{\"mean\": " + number(spread.mean) + ", \"median\": " + number(spread.median) +
         ", \"worst\": " + number(spread.worst) + "}";
}

}  // namespace

SensorFrame to_sensor_frame(const Sample& sample, const World& world) {
  SensorFrame frame;
  frame.stamp = sample.stamp;
  if (sample.odometry) frame.odometry = sample.odometry->velocity;
  if (sample.gyro_rate_in_imu) {
    frame.gyro_rate = world.gyro.base_from_imu.linear() * *sample.gyro_rate_in_imu;
  }
  if (sample.sightings) {
    frame.detections.emplace();
    for (const Sighting& sighting : *sample.sightings) {
      frame.detections->push_back(to_detection(sighting, world.sensor.base_from_optical));
    }
  }
  return frame;
}

std::vector<Detection> to_detections(const Findings& findings, const Eigen::Isometry3d& base_from_optical) {
  std::vector<Detection> detections;
  const Eigen::Matrix3d rotation = base_from_optical.linear();
  for (const Finding& finding : findings.found) {
    Detection detection;
    detection.position_in_optical = finding.position;
    detection.base_from_optical = rotation;
    detection.position_in_base = base_from_optical * finding.position;
    detection.covariance_in_base = rotation * finding.covariance * rotation.transpose();
    detection.signature = finding.signature;
    detection.score = finding.score;
    detections.push_back(std::move(detection));
  }
  return detections;
}

RoomRun run_room(const RoomStudy& study, std::uint64_t seed) {
  const bool spatial = study.pipeline.space == SpaceType::kSpatial;
  return spatial ? run_room_in<Spatial>(study, seed) : run_room_in<Planar>(study, seed);
}

std::vector<RoomRun> run_study(const RoomStudy& study) {
  std::vector<RoomRun> runs(static_cast<std::size_t>(study.seeds));
  for_each_run(
      runs.size(), [&](std::size_t i) { runs[i] = run_room(study, study.first_seed + i); },
      study.on_progress);
  return runs;
}

RoomSummary summarize(const std::vector<RoomRun>& runs) {
  RoomSummary summary;
  summary.runs = runs.size();
  if (runs.empty()) return summary;
  const auto count = static_cast<double>(runs.size());
  summary.true_landmarks = runs.front().map.true_landmarks;
  const auto share = [&](bool (RoomRun::*is_so)() const) {
    return static_cast<double>(std::count_if(runs.begin(), runs.end(), std::mem_fn(is_so))) / count;
  };
  summary.exact_count_share = share(&RoomRun::is_exact);
  summary.success_share = share(&RoomRun::is_success);
  summary.silent_failures =
      static_cast<std::size_t>(std::count_if(runs.begin(), runs.end(), [](const RoomRun& run) {
        const bool is_off = run.map.true_landmarks > 0 && !run.is_accurate();
        return is_off && !run.said_lost;
      }));
  summary.missed = spread(runs, [](const RoomRun& run) { return run.map.missed(); });
  summary.spurious = spread(runs, [](const RoomRun& run) { return run.map.spurious(); });
  summary.wrong_labels = spread(runs, [](const RoomRun& run) { return run.wrong_labels; });
  summary.landmark_rmse_aligned = spread(runs, [](const RoomRun& run) { return run.map.rmse_aligned; });
  summary.landmark_rmse_start = spread(runs, [](const RoomRun& run) { return run.map.rmse; });
  summary.path_rmse = spread(runs, [](const RoomRun& run) { return run.path_rmse; });
  summary.nees = spread(runs, [](const RoomRun& run) { return run.nees_mean; });
  summary.pose_dof = runs.front().pose_dof;
  std::vector<std::vector<double>> nees;
  nees.reserve(runs.size());
  for (const RoomRun& run : runs) nees.push_back(run.nees);
  const Consistency honesty = consistency(nees, summary.pose_dof);
  summary.nees_low = honesty.low;
  summary.nees_high = honesty.high;
  summary.nees_inside_share = honesty.inside_share;
  return summary;
}

std::string to_table(const RoomSummary& s) {
  const auto row = [](const char* name, const Spread& spread, int digits) {
    return format("%-38s %9.*f %9.*f %9.*f\n", name, digits, spread.mean, digits, spread.median, digits,
                  spread.worst);
  };
  std::string text =
      format("%-38s %9s %9s %9s\n", format("%zu runs", s.runs).c_str(), "mean", "median", "worst");
  if (s.true_landmarks > 0) {
    text += row("landmark RMSE, aligned (m)", s.landmark_rmse_aligned, 4) +
            row("landmark RMSE, in the start frame (m)", s.landmark_rmse_start, 4);
  }
  text += row("path RMSE, in the start frame (m)", s.path_rmse, 4);
  if (s.true_landmarks > 0) {
    text += row("landmarks missed", s.missed, 2) + row("landmarks too many", s.spurious, 2) +
            row("labels wrong", s.wrong_labels, 2);
  } else {
    text += row("landmarks in the map", s.spurious, 0);
  }
  text += row(format("pose NEES (%d when consistent)", s.pose_dof).c_str(), s.nees, 2);
  if (s.true_landmarks > 0) {
    text += format(
        "all %zu landmarks and no other: %.0f %% of the runs; with an RMSE of at most 0.09 m: %.0f %%\n",
        s.true_landmarks, 100.0 * s.exact_count_share, 100.0 * s.success_share);
    text += format("farther off than that, and never said \"lost\": %zu\n", s.silent_failures);
  }
  return text +
         format(
             "NEES averaged over the runs: inside its 95 %% bounds, %.2f to %.2f, for %.0f %% of the time\n",
             s.nees_low, s.nees_high, 100.0 * s.nees_inside_share);
}

std::string to_json(const RoomSummary& s, const std::vector<RoomRun>& runs) {
  std::string text =
      "{\n  \"runs\": " + std::to_string(s.runs) +
      ",\n  \"true_landmarks\": " + std::to_string(s.true_landmarks) +
      ",\n  \"exact_count_share\": " + number(s.exact_count_share) +
      ",\n  \"success_share\": " + number(s.success_share) +
      ",\n  \"silent_failures\": " + std::to_string(s.silent_failures) +
      ",\n  \"landmarks_missed\": " + json(s.missed) + ",\n  \"landmarks_spurious\": " + json(s.spurious) +
      ",\n  \"wrong_labels\": " + json(s.wrong_labels) +
      ",\n  \"landmark_rmse_m\": " + json(s.landmark_rmse_aligned) +
      ",\n  \"landmark_rmse_start_m\": " + json(s.landmark_rmse_start) +
      ",\n  \"ate_rmse_start_m\": " + json(s.path_rmse) + ",\n  \"pose_nees\": " + json(s.nees) +
      ",\n  \"pose_dof\": " + std::to_string(s.pose_dof) + ",\n  \"pose_nees_bounds\": [" +
      number(s.nees_low) + ", " + number(s.nees_high) +
      "],\n  \"pose_nees_inside_share\": " + number(s.nees_inside_share) + ",\n  \"seeds\": [\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RoomRun& run = runs[i];
    text += "    {\"seed\": " + std::to_string(run.seed) +
            ", \"landmarks\": " + std::to_string(run.map.estimated_landmarks) +
            ", \"missed\": " + std::to_string(run.map.missed()) +
            ", \"spurious\": " + std::to_string(run.map.spurious()) +
            ", \"wrong_labels\": " + std::to_string(run.wrong_labels) +
            ", \"landmark_rmse_m\": " + number(run.map.rmse_aligned) +
            ", \"landmark_max_m\": " + number(run.map.max_aligned) +
            ", \"landmark_rmse_start_m\": " + number(run.map.rmse) +
            ", \"ate_rmse_start_m\": " + number(run.path_rmse) + ", \"pose_nees\": " + number(run.nees_mean) +
            ", \"said_lost\": " + (run.said_lost ? "true" : "false") +
            ", \"seconds\": " + number(run.seconds) + "}" + (i + 1 < runs.size() ? ",\n" : "\n");
  }
  return text + "  ]\n}\n";
}

}  // namespace kinect_ekf_slam
