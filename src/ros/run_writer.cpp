#include "kinect_ekf_slam/ros/run_writer.h"

#include <ros/common.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/atomic_file.h"
#include "kinect_ekf_slam/core/compatibility.h"

namespace kinect_ekf_slam {
namespace {

/// Appends numbers fast: a run has millions of them.
void append(std::string* text, double value, int digits = 9) {
  if (!std::isfinite(value)) {
    *text += "nan";
    return;
  }
  append_number(text, value, digits);
}

/// Seconds with all nine decimals.
void append_time(std::string* text, TimeNs stamp) {
  char buffer[40];
  const int length =
      std::snprintf(buffer, sizeof(buffer), "%lld.%09lld", static_cast<long long>(stamp / 1000000000),
                    static_cast<long long>(stamp % 1000000000));
  text->append(buffer, static_cast<std::size_t>(length));
}

void append_pose(std::string* text, TimeNs stamp, const Eigen::Isometry3d& map_from_base) {
  append_time(text, stamp);
  const Eigen::Quaterniond rotation(map_from_base.linear());
  for (const double value :
       {map_from_base.translation().x(), map_from_base.translation().y(), map_from_base.translation().z(),
        rotation.x(), rotation.y(), rotation.z(), rotation.w()}) {
    *text += ' ';
    append(text, value);
  }
  *text += '\n';
}

void append_upper_triangle(std::string* text, const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int j = i; j < matrix.cols(); ++j) {
      *text += ',';
      append(text, matrix(i, j));
    }
  }
}

/// A field of a CSV file: quoted when it has to be.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string json_string(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) quoted += c;
  }
  return quoted + "\"";
}

template <class Map>
std::string json_counts(const Map& counts) {
  std::string text = "{";
  for (const auto& [name, count] : counts) {
    text += (text.size() > 1 ? ", " : "") + json_string(name) + ": " + std::to_string(count);
  }
  return text + "}";
}

std::string json_texts(const std::vector<std::string>& texts) {
  std::string text = "[";
  for (const std::string& entry : texts) text += (text.size() > 1 ? ", " : "") + json_string(entry);
  return text + "]";
}

/// Where the map lies in the frame of global positions; null: not known.
std::string json_place(const std::optional<Eigen::Isometry3d>& map_from_global) {
  if (!map_from_global) return "null";
  const Eigen::Isometry3d global_from_map = map_from_global->inverse();
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    text += std::string(axis == 0 ? "{" : ", ") + "\"" + "xyz"[axis] + "\": ";
    append(&text, global_from_map.translation()(axis), 12);
  }
  text += ", \"yaw_deg\": ";
  append(&text, degrees(std::atan2(global_from_map.linear()(1, 0), global_from_map.linear()(0, 0))), 12);
  return text + "}";
}

/// What the program was made from.
std::string json_versions() {
  const auto dotted = [](int major, int minor, int patch) {
    return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
  };
#ifdef __clang__
  const std::string compiler = __VERSION__;
#else
  const std::string compiler = "GCC " __VERSION__;
#endif
  return "{\"kinect_ekf_slam\": " + json_string(PACKAGE_VERSION) +
         ", \"roscpp\": " + json_string(dotted(ROS_VERSION_MAJOR, ROS_VERSION_MINOR, ROS_VERSION_PATCH)) +
         ", \"Eigen\": " +
         json_string(dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)) +
         ", \"compiler\": " + json_string(compiler) + "}";
}

/// The wall clock, ISO 8601.
std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char buffer[32];
  std::strftime(buffer, sizeof(buffer), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return buffer;
}

std::string covariance_header() {
  const char* axes = "xyzrpw";
  std::string header = "t";
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) header += std::string(",c") + axes[i] + axes[j];
  }
  return header + "\n";
}

}  // namespace

RunWriter::RunWriter(const std::string& directory, double trajectory_rate)
    : directory_(directory), period_(trajectory_rate > 0.0 ? to_nanoseconds(1.0 / trajectory_rate) : 0) {
  std::error_code error;
  std::filesystem::create_directories(directory_, error);
  if (error) throw std::runtime_error(directory_ + ": cannot be created: " + error.message());
  restart();
}

void RunWriter::restart() {
  trajectory_.text.clear();
  dead_reckoning_.text.clear();
  covariance_.text = covariance_header();
  positions_.text = "t,beacon,verdict,nis,dof,x,y,z\n";
  position_verdicts_.clear();
  map_from_global_.reset();
  rows_.clear();
  instant_rows_.clear();
  merged_.clear();
  removed_.clear();
  has_written_ = false;
}

RunWriter::~RunWriter() = default;

bool RunWriter::wants_pose(TimeNs stamp, bool looked) const {
  return !has_written_ || (stamp > last_written_ && (looked || stamp - last_written_ >= period_));
}

void RunWriter::add(const SensorFrame& frame, const SlamResult& result) {
  ++frames_;
  if (result.looked) ++detection_frames_;
  for (std::size_t i = 0; i < result.outcomes.size(); ++i) {
    const DetectionOutcome& outcome = result.outcomes[i];
    instant_rows_.push_back({frame.stamp, static_cast<int>(i), outcome.source_id, outcome.verdict,
                             outcome.landmark_id, outcome.nis});
    rows_.push_back(instant_rows_.back());
  }
  revise(result);
  map_from_global_ = result.map_from_global;
  for (const PositionOutcome& outcome : result.positions) add_position(frame.stamp, outcome);
  if (!result.finite) return;
  const TimeNs stamp = result.pose.stamp;
  if (!wants_pose(stamp, result.looked)) return;
  has_written_ = true;
  last_written_ = stamp;
  append_pose(&trajectory_.text, stamp, result.pose.map_from_base);
  append_pose(&dead_reckoning_.text, stamp, result.dead_reckoned);
  append_time(&covariance_.text, stamp);
  append_upper_triangle(&covariance_.text, result.pose.covariance);
  covariance_.text += '\n';
}

void RunWriter::add_position(TimeNs stamp, const PositionOutcome& outcome) {
  ++position_verdicts_[to_string(outcome.verdict)];
  append_time(&positions_.text, stamp);
  positions_.text += ',' + std::to_string(outcome.beacon) + ',' + to_string(outcome.verdict) + ',';
  if (std::isfinite(outcome.nis)) append(&positions_.text, outcome.nis, 6);
  positions_.text += ',' + std::to_string(outcome.dof);
  for (const double value : outcome.position_in_map) {
    positions_.text += ',';
    if (std::isfinite(value)) append(&positions_.text, value);
  }
  positions_.text += '\n';
}

void RunWriter::revise(const SlamResult& result) {
  for (const RevisedOutcome& revision : result.revisions) {
    const auto key = [](const auto& row) { return std::make_pair(row.stamp, row.detection); };
    const auto row =
        std::lower_bound(rows_.begin(), rows_.end(), revision,
                         [&](const auto& left, const auto& right) { return key(left) < key(right); });
    if (row == rows_.end() || key(*row) != key(revision)) continue;
    row->verdict = revision.verdict;
    row->landmark = revision.landmark_id;
    row->nis = revision.nis;
  }
  merged_.insert(merged_.end(), result.merged.begin(), result.merged.end());
  removed_.insert(result.removed.begin(), result.removed.end());
}

std::string RunWriter::to_csv(const std::vector<AssociationRow>& rows) {
  std::string text = "t,detection,source_id,verdict,landmark,nis\n";
  for (const AssociationRow& row : rows) {
    append_time(&text, row.stamp);
    text += ',' + std::to_string(row.detection) + ',' + std::to_string(row.source_id) + ',' +
            to_string(row.verdict) + ',' + std::to_string(row.landmark) + ',';
    if (std::isfinite(row.nis)) append(&text, row.nis, 6);
    text += '\n';
  }
  return text;
}

/// Sightings of a landmark that turned out to be another one, or nothing.
void RunWriter::settle_rows(const std::vector<Landmark3d>& map) {
  std::map<int, int> now;
  for (auto merge = merged_.rbegin(); merge != merged_.rend(); ++merge) {
    const auto later = now.find(merge->second);
    now[merge->first] = later == now.end() ? merge->second : later->second;
  }
  std::set<int> present;
  for (const Landmark3d& landmark : map) {
    if (landmark.confirmed) present.insert(landmark.id);
  }
  for (AssociationRow& row : rows_) {
    const auto renamed = now.find(row.landmark);
    if (renamed != now.end()) row.landmark = renamed->second;
    const bool is_gone = present.count(row.landmark) == 0 && removed_.count(row.landmark) > 0;
    if (is_accepted(row.verdict) && is_gone) row.verdict = Verdict::kClutter;
  }
}

std::string RunWriter::landmark_rows(const std::vector<Landmark3d>& map) {
  std::string text = "id,label,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,observations\n";
  for (const Landmark3d& landmark : map) {
    if (!landmark.confirmed) continue;
    text += std::to_string(landmark.id) + ',' + csv_field(landmark.label);
    for (const double value : landmark.position_in_map) {
      text += ',';
      append(&text, value);
    }
    append_upper_triangle(&text, landmark.covariance);
    text += ',' + std::to_string(landmark.observations) + '\n';
  }
  return text;
}

void RunWriter::write_beacons(const std::vector<Landmark3d>& beacons) {
  beacons_.text = landmark_rows(beacons);
}

void RunWriter::write_summary(const std::vector<Landmark3d>& map, const Summary& summary) {
  std::vector<double> times = summary.update_milliseconds;
  std::sort(times.begin(), times.end());
  const double mean =
      times.empty() ? 0.0
                    : std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
  const double percentile_99 = times.empty() ? 0.0 : times[(times.size() - 1) * 99 / 100];
  std::map<std::string, std::uint64_t> verdicts;
  for (const AssociationRow& row : rows_) ++verdicts[to_string(row.verdict)];
  const auto landmarks = std::count_if(map.begin(), map.end(), [](const auto& l) { return l.confirmed; });
  std::ostringstream json;
  json << "{\n  \"bag\": " << json_string(summary.bag) << ",\n  \"finished\": " << json_string(utc_now())
       << ",\n  \"versions\": " << json_versions() << ",\n  \"warnings\": " << json_texts(summary.warnings)
       << ",\n  \"wall_seconds\": " << summary.wall_seconds << ",\n  \"cpu_seconds\": " << summary.cpu_seconds
       << ",\n  \"data_seconds\": " << summary.data_seconds << ",\n  \"times_real_time\": "
       << (summary.wall_seconds > 0.0 ? summary.data_seconds / summary.wall_seconds : 0.0)
       << ",\n  \"frames\": " << frames_ << ",\n  \"detection_frames\": " << detection_frames_
       << ",\n  \"detections\": " << json_counts(verdicts)
       << ",\n  \"positions\": " << json_counts(position_verdicts_)
       << ",\n  \"map_in_fusion_frame\": " << json_place(map_from_global_)
       << ",\n  \"messages\": " << json_counts(summary.accepted)
       << ",\n  \"messages_refused\": " << json_counts(summary.refusals)
       << ",\n  \"landmarks\": " << landmarks << ",\n  \"update_ms_mean\": " << mean
       << ",\n  \"update_ms_p99\": " << percentile_99 << "\n}\n";
  summary_.text = json.str();
}

void RunWriter::finish(const std::vector<Landmark3d>& map, const Summary& summary) {
  settle_rows(map);
  associations_.text = to_csv(rows_);
  instant_associations_.text = to_csv(instant_rows_);
  landmarks_.text = landmark_rows(map);
  parameters_.text = "# what was given; all else as built in\n" + summary.parameters + "\n";
  write_summary(map, summary);
  for (const File* file : {&trajectory_, &covariance_, &dead_reckoning_, &positions_, &beacons_,
                           &associations_, &instant_associations_, &landmarks_, &parameters_, &summary_}) {
    write_file_atomically(directory_ + "/" + file->name, file->text);
  }
}

void remove_run(const std::string& directory) {
  std::error_code error;
  if (!std::filesystem::exists(directory + "/trajectory.tum", error)) return;
  std::filesystem::remove_all(directory, error);
  if (error) throw std::runtime_error(directory + ": cannot be removed: " + error.message());
}

}  // namespace kinect_ekf_slam
