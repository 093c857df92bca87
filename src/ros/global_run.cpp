#include "kinect_ekf_slam/ros/global_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/atomic_file.h"

namespace kinect_ekf_slam {
namespace {

using Clock = std::chrono::steady_clock;

std::string seconds_text(TimeNs stamp) {
  std::ostringstream text;
  text.precision(3);
  text << std::fixed << to_seconds(stamp);
  return text.str();
}

std::string maps_text(const GlobalMap3d::Segment& segment) {
  return segment.first_map == segment.last_map
             ? "local map " + std::to_string(segment.first_map)
             : "local maps " + std::to_string(segment.first_map) + " to " + std::to_string(segment.last_map);
}

/// A row a segment: its time, its local maps, its positions, and where its frame lies in the global one.
std::string segment_rows(const GlobalMap3d& map) {
  std::ostringstream rows;
  rows.precision(9);
  rows << "segment,first_map,last_map,start,end,positions,left_out,placed,x,y,z,yaw_deg,sigma_x,sigma_y,"
          "sigma_z,sigma_yaw_deg,refusal\n";
  for (std::size_t i = 0; i < map.segments.size(); ++i) {
    const GlobalMap3d::Segment& segment = map.segments[i];
    rows << i << ',' << segment.first_map << ',' << segment.last_map << ',' << seconds_text(segment.start)
         << ',' << seconds_text(segment.end) << ',' << segment.positions << ',' << segment.left_out.size()
         << ',' << (segment.refusal.empty() ? 1 : 0);
    if (segment.refusal.empty()) {
      const Eigen::Isometry3d& place = segment.global_from_local.map_from_base;
      const Eigen::Matrix<double, 6, 1> sigmas =
          segment.global_from_local.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
      for (const double value : place.translation()) rows << ',' << value;
      rows << ',' << degrees(std::atan2(place.linear()(1, 0), place.linear()(0, 0)));
      for (const int axis : {0, 1, 2}) rows << ',' << sigmas(axis);
      rows << ',' << degrees(sigmas(5)) << ",\n";
    } else {
      rows << ",,,,,,,,,\"" << segment.refusal << "\"\n";
    }
  }
  return rows.str();
}

/// The positions as they were measured, and what became of each.
void add_positions(const GlobalMap3d& map, RunWriter* writer) {
  std::set<TimeNs> used;
  std::set<TimeNs> left_out;
  for (const GlobalMap3d::Segment& segment : map.segments) {
    for (const auto& contradiction : segment.left_out) left_out.insert(contradiction.stamp);
    if (!segment.refusal.empty()) continue;
    for (const GlobalMap3d::Position& position : map.positions) {
      if (position.stamp >= segment.start && position.stamp < segment.end) used.insert(position.stamp);
    }
  }
  for (const GlobalMap3d::Position& position : map.positions) {
    PositionOutcome outcome;
    outcome.verdict = left_out.count(position.stamp) > 0 ? PositionVerdict::kOutsideGate
                      : used.count(position.stamp) > 0   ? PositionVerdict::kUsed
                                                         : PositionVerdict::kAligning;
    outcome.position_in_map = position.antenna;
    writer->add_position(position.stamp, outcome);
  }
}

std::vector<std::string> warnings_of(const GlobalMap3d& map, const std::string& frame) {
  std::vector<std::string> lines;
  for (const GlobalMap3d::Segment& segment : map.segments) {
    std::ostringstream line;
    line.precision(2);
    line << std::fixed << maps_text(segment) << ", " << seconds_text(segment.start) << " to "
         << seconds_text(segment.end) << " s: ";
    if (!segment.refusal.empty()) {
      line << "not placed in '" << frame << "': " << segment.refusal;
      lines.push_back(line.str());
      continue;
    }
    if (segment.left_out.empty()) continue;
    const GlobalMap3d::Contradiction& first = segment.left_out.front();
    line << segment.left_out.size() << " of " << segment.positions
         << " positions contradict the path and are left out; the first at " << seconds_text(first.stamp)
         << " s: (" << first.by_position.x() << ", " << first.by_position.y() << ") m measured, ("
         << first.by_path.x() << ", " << first.by_path.y() << ") m by the path";
    lines.push_back(line.str());
  }
  if (map.ignored > 0) {
    lines.push_back(std::to_string(map.ignored) + " positions ignored: they are not in '" + frame +
                    "' as the first one is");
  }
  return lines;
}

/// There were none, or none could be used: told by what became of them.
std::string why_no_positions(const FusionOptions& fusion, const RunWriter::Summary& summary) {
  std::uint64_t came = 0;
  std::string reasons;
  const auto tell = [&](std::uint64_t count, const std::string& reason) {
    came += count;
    reasons += (reasons.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  };
  for (const std::string kind : {"global_position", "fix"}) {
    const auto accepted = summary.accepted.find(kind);
    if (accepted != summary.accepted.end() && accepted->second > 0)
      tell(accepted->second, kind + ": withheld, or the covariance is none");
    for (const auto& [reason, count] : summary.refusals) {
      if (reason.rfind(kind + ":", 0) == 0) tell(count, reason);
    }
  }
  if (came > 0)
    return "none of the run's " + std::to_string(came) + " global positions can be used: " + reasons;
  return "the run has no global positions; a map in their frame needs some on '" + fusion.positions_topic +
         "' (fusion/positions_topic) or " +
         (fusion.fix_topic.empty() ? "fusion/fix_topic" : "'" + fusion.fix_topic + "'");
}

}  // namespace

GlobalRun::GlobalRun(const RunOptions& options) : options_(options) { restart(); }

void GlobalRun::restart() {
  try {
    mapper_ = make_global_mapper(options_.pipeline);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string("--global: ") + error.what());
  }
  dead_reckoned_.clear();
}

void GlobalRun::add(const SensorFrame& frame, const SlamResult& result) {
  const bool late = !dead_reckoned_.empty() && frame.stamp < dead_reckoned_.back().stamp;
  if (late || !result.finite) return;
  mapper_->add(frame);
  dead_reckoned_.push_back({frame.stamp, result.dead_reckoned});
}

const Eigen::Isometry3d& GlobalRun::dead_reckoned_at(TimeNs stamp) const {
  const auto after =
      std::lower_bound(dead_reckoned_.begin(), dead_reckoned_.end(), stamp,
                       [](const DeadReckoned& pose, TimeNs time) { return pose.stamp < time; });
  return (after == dead_reckoned_.end() ? dead_reckoned_.back() : *after).map_from_base;
}

/// Dead reckoning starts where the first placed pose is.
void GlobalRun::write_path(const GlobalMap3d& map, RunWriter* writer) const {
  std::optional<Eigen::Isometry3d> global_from_map;
  for (const GlobalMap3d::Segment& segment : map.segments) {
    for (const Pose3d& pose : segment.path) {
      const Eigen::Isometry3d& dead_reckoned = dead_reckoned_at(pose.stamp);
      if (!global_from_map) global_from_map = pose.map_from_base * dead_reckoned.inverse();
      SensorFrame frame;
      frame.stamp = pose.stamp;
      SlamResult result;
      result.pose = pose;
      result.dead_reckoned = *global_from_map * dead_reckoned;
      writer->add(frame, result);
    }
  }
}

GlobalRunReport GlobalRun::finish(const std::string& directory, const RunWriter::Summary& summary) const {
  const Clock::time_point start = Clock::now();
  const GlobalMap3d map = mapper_->integration()();
  GlobalRunReport report;
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  report.frame = frame_of(map, options_);
  report.segments = map.segments.size();
  report.landmarks = map.landmarks.size();
  report.merged_landmarks = map.merged_landmarks;
  report.positions = map.positions.size();
  for (const GlobalMap3d::Segment& segment : map.segments) {
    report.local_maps += static_cast<std::size_t>(segment.last_map - segment.first_map + 1);
    report.placed += segment.refusal.empty() ? 1 : 0;
    report.left_out += segment.left_out.size();
  }
  report.warnings = warnings_of(map, report.frame);
  if (report.positions == 0) {
    throw std::runtime_error("--global: " + why_no_positions(options_.fusion, summary));
  }
  if (report.segments == 0) throw std::runtime_error("--global: the run has no way: no odometry came");
  if (report.placed == 0) throw std::runtime_error("--global: " + report.warnings.front());

  RunWriter writer(directory, options_.output.trajectory_rate);
  write_path(map, &writer);
  add_positions(map, &writer);
  RunWriter::Summary global_summary = summary;
  global_summary.wall_seconds = report.seconds;
  global_summary.update_milliseconds.clear();
  global_summary.warnings.insert(global_summary.warnings.end(), report.warnings.begin(),
                                 report.warnings.end());
  writer.finish(map.landmarks, global_summary);
  write_file_atomically(directory + "/segments.csv", segment_rows(map));
  return report;
}

}  // namespace kinect_ekf_slam
