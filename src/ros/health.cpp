#include "kinect_ekf_slam/ros/health.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/ros/conversions.h"

namespace kinect_ekf_slam {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr double kSilence = 3.0;      // s without odometry before that is a warning
constexpr double kLongWait = 0.5;     // s in the queue before that is a warning
constexpr double kNisMemory = 50.0;   // updates
constexpr double kNisTooLarge = 3.0;  // mean of nu^T S^-1 nu per degree of freedom

const char* to_string(Localization localization) {
  switch (localization) {
    case Localization::kTracking:
      return "tracking";
    case Localization::kSearching:
      return "searching";
    case Localization::kLost:
      return "lost";
    case Localization::kFound:
      return "found";
  }
  return "";
}

}  // namespace

void Health::note_input(const std::string& input, const ros::Time& now, const ros::Time& received) {
  Input& entry = inputs_[input];
  entry.longest_wait = std::max(entry.longest_wait, seconds_between(received, now));
  entry.last = now;
  ++entry.since_report;
}

void Health::note_result(const SlamResult& result) {
  finite_ = result.finite;
  localization_ = result.localization;
  for (const DetectionOutcome& outcome : result.outcomes)
    ++verdicts_[static_cast<std::size_t>(outcome.verdict)];
  for (const PositionOutcome& outcome : result.positions)
    ++position_verdicts_[static_cast<std::size_t>(outcome.verdict)];
  is_aligned_ = result.map_from_global.has_value();
  if (result.looked) ++looked_;
  if (result.looked && result.outcomes.empty()) ++saw_nothing_;
  if (result.dof == 0) return;
  ++updates_;
  const double weight = 1.0 / std::min(static_cast<double>(updates_), kNisMemory);
  nis_per_dof_ += weight * (result.nis / result.dof - nis_per_dof_);
}

void Health::note_autosave(const std::string& outcome, bool sound) {
  autosave_ = outcome;
  autosave_sound_ = sound;
}

void Health::set_state(const std::string& mode, bool paused) {
  mode_ = mode;
  paused_ = paused;
}

void Health::reset_estimate() {
  std::fill(verdicts_.begin(), verdicts_.end(), 0);
  std::fill(position_verdicts_.begin(), position_verdicts_.end(), 0);
  is_aligned_ = false;
  nis_per_dof_ = 1.0;
  updates_ = 0;
  looked_ = 0;
  saw_nothing_ = 0;
  finite_ = true;
  localization_ = Localization::kTracking;
  landmarks_ = 0;
}

void Health::report_inputs(const SensorBridge& bridge, const ros::Time& now,
                           diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(DiagnosticStatus::OK, "inputs arrive");
  std::map<std::string, std::uint64_t> refused_of;
  for (const auto& [reason, count] : bridge.refusals())
    refused_of[reason.substr(0, reason.find(':'))] += count;
  const double elapsed = std::max(seconds_between(last_report_, now), 1e-3);
  std::map<std::string, std::string> topics = expectation_.position_topics;
  topics.insert({{"odometry", expectation_.odometry_topic},
                 {"imu", expectation_.imu_topic},
                 {"landmarks", expectation_.landmarks_topic}});
  for (auto& [name, topic] : topics) {
    Input& input = inputs_[name];
    status.add(name + " topic", topic);
    status.addf(name + " rate (Hz)", "%.1f", static_cast<double>(input.since_report) / elapsed);
    status.add(name + " age of the last (s)", input.last.isZero()
                                                  ? std::string("never came")
                                                  : std::to_string(seconds_between(input.last, now)));
    status.addf(name + " longest wait (s)", "%.3f", input.longest_wait);
    if (input.longest_wait > kLongWait) {
      status.summary(DiagnosticStatus::WARN,
                     "messages on " + topic + " wait: more come than the node can use");
    }
    input.longest_wait = 0.0;
    const std::uint64_t refused = refused_of[name];
    const std::uint64_t newly_refused = refused - std::min(refused, input.refused);
    if (newly_refused > 1 && newly_refused >= input.since_report)
      status.summary(DiagnosticStatus::WARN, "every message on " + topic + " is refused");
    input.refused = refused;
    input.since_report = 0;
  }
  last_report_ = now;
  std::uint64_t refused = 0;
  for (const auto& [reason, count] : bridge.refusals()) {
    status.add("refused, " + reason, count);
    refused += count;
  }
  status.add("refused", refused);
  const Input& odometry = inputs_["odometry"];
  const ros::Time since = odometry.last.isZero() ? start_ : odometry.last;
  if (seconds_between(since, now) > kSilence) {
    status.summary(DiagnosticStatus::WARN,
                   (odometry.last.isZero() ? "no odometry yet on " : "odometry has stopped on ") +
                       expectation_.odometry_topic);
  }
}

void Health::report_estimate(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  const double sigma = std::sqrt(pose_.covariance.diagonal().head(expectation_.position_axes).maxCoeff());
  status.summary(DiagnosticStatus::OK, "estimating");
  if (paused_) status.summary(DiagnosticStatus::OK, "paused: detections are not used");
  if (!autosave_sound_) status.summary(DiagnosticStatus::WARN, "the map is not saved: " + autosave_);
  if (nis_per_dof_ > kNisTooLarge) {
    status.summary(DiagnosticStatus::WARN,
                   "sightings fit worse than the covariance says: is a noise or calibration wrong?");
  }
  if (sigma > expectation_.position_sigma_warning)
    status.summary(DiagnosticStatus::WARN, "the position is uncertain");
  if (localization_ == Localization::kSearching)
    status.summary(DiagnosticStatus::WARN, "searching for the robot in the map: its pose is unknown");
  if (localization_ == Localization::kLost) {
    status.summary(
        DiagnosticStatus::ERROR,
        "lost: most of what is seen fits nothing in the map, or positions and ranges contradict the "
        "estimate; tell it by initialpose where it is");
  }
  if (!finite_)
    status.summary(DiagnosticStatus::ERROR, "the estimate is not finite; output stopped; call ~reset");
  status.add("mode", mode_);
  status.add("localization", to_string(localization_));
  status.add("paused", paused_ ? "yes" : "no");
  status.add("landmarks", landmarks_);
  if (!autosave_.empty()) status.add("autosave", autosave_);
  status.addf("position sigma (m)", "%.4f", sigma);
  status.addf("heading sigma (deg)", "%.3f", degrees(std::sqrt(pose_.covariance(5, 5))));
  status.addf("NIS per degree of freedom", "%.3f", nis_per_dof_);
  status.add("detection messages used", looked_);
  status.add("detection messages that saw nothing", saw_nothing_);
  for (int i = 0; i < kVerdictCount; ++i) {
    status.add(std::string("detections, ") + to_string(static_cast<Verdict>(i)), verdicts_[i]);
  }
  if (std::all_of(position_verdicts_.begin(), position_verdicts_.end(), [](auto n) { return n == 0; }))
    return;
  status.add("map placed in the frame of global positions", is_aligned_ ? "yes" : "not yet");
  for (int i = 0; i < kPositionVerdictCount; ++i) {
    status.add(std::string("positions and ranges, ") + to_string(static_cast<PositionVerdict>(i)),
               position_verdicts_[i]);
  }
}

}  // namespace kinect_ekf_slam
