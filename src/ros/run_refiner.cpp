#include "kinect_ekf_slam/ros/run_refiner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/atomic_file.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/pipeline/pose_3d.h"
#include "kinect_ekf_slam/ros/calibration_report.h"
#include "kinect_ekf_slam/smoothing/batch.h"

namespace kinect_ekf_slam {
namespace {

using Clock = std::chrono::steady_clock;

/// Root mean square, of what is added.
class Rms {
 public:
  void add(double value) {
    squares_ += value * value;
    largest_ = std::max(largest_, std::abs(value));
    ++count_;
  }
  double value() const { return count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) : 0.0; }
  double largest() const { return largest_; }

 private:
  double squares_ = 0.0;
  double largest_ = 0.0;
  std::size_t count_ = 0;
};

template <class Space>
class Refiner {
 public:
  Refiner(const FinishedRun& run, const RunOptions& options)
      : run_(run),
        options_(options),
        gate_(chi_square_quantile(options.pipeline.association.gate_probability, Space::kPointDim)) {
    collect_path();
    collect_landmarks();
    collect_sightings();
    batch_options_.motion = options.pipeline.motion;
    batch_options_.sensor = options.pipeline.sensor;
  }

  RefinementReport refine(const std::string& directory, const std::function<void(double)>& on_progress) {
    const Clock::time_point start = Clock::now();
    batch_options_.on_progress = on_progress;
    const BatchResult<Space> result = batch_optimum(recorded_, batch_options_);
    RefinementReport report;
    report.sightings = recorded_.sightings.size();
    for (const SightingOutcome& outcome : result.sightings)
      report.doubted += outcome.squared_error > gate_ ? 1 : 0;
    if (!result.converged)
      report.warnings.push_back("the refinement has not settled: its files are of the last round");
    if (run_.recorder.has_positions()) {
      report.warnings.push_back("positions and ranges to beacons do not enter the refinement");
    }
    report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    write_run(result, directory, report);
    const std::vector<CalibratedValue> values = calibrated_values(result, batch_options_.prior, options_);
    for (const CalibratedValue& value : values) report.calibration.push_back(calibration_line(value));
    report.path_difference = path_difference_.value();
    report.landmark_difference = landmark_difference_.value();
    write_file_atomically(directory + "/calibration.yaml", calibration_yaml(values, run_.summary.bag));
    write_file_atomically(directory + "/refinement.json", json(result, values, report));
    return report;
  }

 private:
  void collect_path() {
    for (const RunRecorder::Frame& frame : run_.recorder.frames()) {
      recorded_.path.push_back({frame.stamp, Space::pose_from_3d(frame.map_from_base)});
      recorded_.velocities.push_back({frame.stamp, frame.velocity, frame.hold_time});
    }
    recorded_.start_covariance = to_estimate<Space>(run_.recorder.start()).covariance;
  }

  void collect_landmarks() {
    for (const Landmark3d& landmark : run_.map) {
      if (!landmark.confirmed) continue;
      index_of_landmark_[landmark.id] = static_cast<int>(recorded_.landmarks_in_map.size());
      recorded_.landmarks_in_map.push_back(Space::from_3d(landmark.position_in_map));
      map_.push_back(landmark);
    }
  }

  /// What the filter took for a landmark of the map; where identities are read, also what it found too far
  /// off.
  void collect_sightings() {
    const bool known = options_.pipeline.association.type == AssociationOptions::Type::kKnown;
    auto row = run_.associations.begin();
    for (const RunRecorder::Frame& frame : run_.recorder.frames()) {
      if (!frame.looked) continue;
      while (row != run_.associations.end() && row->stamp < frame.stamp) ++row;
      for (; row != run_.associations.end() && row->stamp == frame.stamp; ++row) {
        const auto landmark = index_of_landmark_.find(row->landmark);
        const bool is_told = is_accepted(row->verdict) || (known && row->verdict == Verdict::kOutsideGate);
        if (!is_told || landmark == index_of_landmark_.end()) continue;
        if (static_cast<std::size_t>(row->detection) >= frame.detections.size()) continue;
        sighting_of_row_[&*row] = recorded_.sightings.size();
        recorded_.sightings.push_back({frame.stamp, frame.detections[row->detection], landmark->second});
      }
    }
  }

  void write_run(const BatchResult<Space>& result, const std::string& directory,
                 const RefinementReport& report) {
    RunWriter writer(directory, options_.output.trajectory_rate);
    TimeNs last = recorded_.path.front().stamp;
    typename Space::Pose dead_reckoned = result.path.at(last).map_from_base;
    auto row = run_.associations.begin();
    for (const RunRecorder::Frame& frame : run_.recorder.frames()) {
      if (!writer.wants_pose(frame.stamp, frame.looked)) continue;
      SlamResult refined;
      refined.pose = to_3d<Space>(frame.stamp, result.path.at(frame.stamp));
      dead_reckoned = dead_reckoned * result.path.odometry().between(last, frame.stamp).delta;
      last = frame.stamp;
      refined.dead_reckoned = Space::to_3d(dead_reckoned);
      refined.looked = frame.looked;
      while (row != run_.associations.end() && row->stamp < frame.stamp) ++row;
      for (; row != run_.associations.end() && row->stamp == frame.stamp; ++row) {
        refined.outcomes.push_back(outcome(result, *row));
      }
      compare(frame, refined.pose);
      SensorFrame stamped;
      stamped.stamp = frame.stamp;
      writer.add(stamped, refined);
    }
    RunWriter::Summary summary = run_.summary;
    summary.wall_seconds = report.seconds;
    summary.warnings.insert(summary.warnings.end(), report.warnings.begin(), report.warnings.end());
    summary.update_milliseconds.clear();
    writer.finish(refined_map(result), summary);
  }

  DetectionOutcome outcome(const BatchResult<Space>& result, const RunWriter::AssociationRow& row) const {
    DetectionOutcome outcome;
    outcome.source_id = row.source_id;
    outcome.verdict = row.verdict;
    outcome.landmark_id = row.landmark;
    outcome.nis = row.nis;
    const auto sighting = sighting_of_row_.find(&row);
    if (sighting == sighting_of_row_.end()) return outcome;
    outcome.nis = result.sightings[sighting->second].squared_error;
    outcome.verdict = outcome.nis <= gate_ ? Verdict::kMatched : Verdict::kOutsideGate;
    return outcome;
  }

  std::vector<Landmark3d> refined_map(const BatchResult<Space>& result) {
    std::vector<Landmark3d> map = map_;
    for (std::size_t i = 0; i < map.size(); ++i) {
      const auto& refined = result.landmarks[i];
      if (!refined.was_seen) continue;  // the filter's stays: nothing of this run tells of it
      landmark_difference_.add((recorded_.landmarks_in_map[i] - refined.in_map).norm());
      map[i].position_in_map = Space::to_3d(refined.in_map);
      map[i].covariance.template topLeftCorner<Space::kPointDim, Space::kPointDim>() = refined.covariance;
    }
    return map;
  }

  void compare(const RunRecorder::Frame& frame, const Pose3d& refined) {
    const Eigen::Isometry3d change = refined.map_from_base.inverse() * frame.map_from_base;
    path_difference_.add(change.translation().norm());
    turn_difference_.add(Eigen::AngleAxisd(change.linear()).angle());
  }

  std::string json(const BatchResult<Space>& result, const std::vector<CalibratedValue>& values,
                   const RefinementReport& report) const {
    std::ostringstream json;
    json.precision(9);
    json << "{\n  \"seconds\": " << report.seconds << ",\n  \"rounds\": " << result.rounds
         << ",\n  \"converged\": " << (result.converged ? "true" : "false")
         << ",\n  \"cost\": " << result.cost << ",\n  \"sightings\": " << report.sightings
         << ",\n  \"sightings_doubted\": " << report.doubted
         << ",\n  \"calibration\": " << calibration_json(values)
         << ",\n  \"from_filter\": {\"path_rms_m\": " << path_difference_.value()
         << ", \"path_max_m\": " << path_difference_.largest()
         << ", \"turn_rms_deg\": " << degrees(turn_difference_.value())
         << ", \"landmark_rms_m\": " << landmark_difference_.value()
         << ", \"landmark_max_m\": " << landmark_difference_.largest() << "}\n}\n";
    return json.str();
  }

  const FinishedRun& run_;
  const RunOptions& options_;
  double gate_;
  RecordedRun<Space> recorded_;
  std::vector<Landmark3d> map_;  ///< the filter's, confirmed
  std::map<int, int> index_of_landmark_;
  std::map<const RunWriter::AssociationRow*, std::size_t> sighting_of_row_;
  BatchOptions batch_options_;
  Rms path_difference_;
  Rms turn_difference_;
  Rms landmark_difference_;
};

}  // namespace

void require_refining(const RunOptions& options) {
  if (options.pipeline.mode == Mode::kLocalization) {
    throw std::runtime_error(
        "--refine: mode is localization; a run that makes its map, mode slam, is needed");
  }
}

RefinementReport refine_run(const FinishedRun& run, const RunOptions& options, const std::string& directory,
                            const std::function<void(double)>& on_progress) {
  try {
    if (options.pipeline.space == SpaceType::kSpatial) {
      return Refiner<Spatial>(run, options).refine(directory, on_progress);
    }
    return Refiner<Planar>(run, options).refine(directory, on_progress);
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("--refine: ") + error.what());
  }
}

}  // namespace kinect_ekf_slam
