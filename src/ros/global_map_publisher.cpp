#include "kinect_ekf_slam/ros/global_map_publisher.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "kinect_ekf_slam/ros/conversions.h"
#include "kinect_ekf_slam/ros/names.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kPollPeriod = 0.1;  // s, wall time

std::string point_text(const Eigen::Vector3d& point) {
  char text[96];
  std::snprintf(text, sizeof(text), "(%.2f, %.2f, %.2f) m", point.x(), point.y(), point.z());
  return text;
}

}  // namespace

GlobalMapPublisher::GlobalMapPublisher(const ros::NodeHandle& private_handle, const RunOptions& options)
    : private_handle_(private_handle),
      options_(options),
      mapper_(make_global_mapper(options.pipeline)),
      painter_(options.fusion.frame, options.output.marker_sigmas, options.pipeline.space),
      map_publisher_(private_handle_.advertise<LandmarkMap>(names::kGlobalMap, 1, true)),
      marker_publisher_(
          private_handle_.advertise<visualization_msgs::MarkerArray>(names::kGlobalMarkers, 1, true)),
      timer_(private_handle_.createWallTimer(ros::WallDuration(kPollPeriod),
                                             [this](const ros::WallTimerEvent&) { poll(); })) {}

void GlobalMapPublisher::add(const SensorFrame& frame) {
  mapper_->add(frame);
  newest_ = frame.stamp;
  has_news_ = true;
}

void GlobalMapPublisher::restart() {
  mapper_ = make_global_mapper(options_.pipeline);
  map_ = {};
  has_news_ = false;
  next_is_of_this_run_ = false;
  publish();
}

void GlobalMapPublisher::poll() {
  if (next_.valid()) {
    if (next_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    try {
      GlobalMap3d map = next_.get();
      if (next_is_of_this_run_) map_ = std::move(map);
      failure_.clear();
    } catch (const std::exception& error) {
      failure_ = error.what();
    }
    if (next_is_of_this_run_) publish();
  }
  const bool is_due = (ros::WallTime::now() - begun_).toSec() >= options_.global_map.period;
  if (!has_news_ || !is_due) return;
  begun_ = ros::WallTime::now();
  has_news_ = false;
  next_is_of_this_run_ = true;
  next_ = std::async(std::launch::async, mapper_->integration());
}

void GlobalMapPublisher::publish() {
  const std::string& frame = frame_of(map_, options_);
  map_publisher_.publish(to_message(map_.landmarks, frame, newest_));
  painter_.set_frame(frame);
  marker_publisher_.publish(painter_.paint_global(map_));
}

void GlobalMapPublisher::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  const auto placed = std::count_if(map_.segments.begin(), map_.segments.end(),
                                    [](const auto& segment) { return segment.refusal.empty(); });
  std::size_t left_out = 0;
  const GlobalMap3d::Contradiction* last = nullptr;
  for (const GlobalMap3d::Segment& segment : map_.segments) {
    left_out += segment.left_out.size();
    if (!segment.left_out.empty()) last = &segment.left_out.back();
  }
  status.summaryf(DiagnosticStatus::OK, "%zd of %zu stretches placed", placed, map_.segments.size());
  if (map_.positions.empty()) {
    status.summary(DiagnosticStatus::OK, "no global positions yet");
  } else if (map_.segments.empty()) {
    status.summary(DiagnosticStatus::OK, "no way yet");
  } else if (placed == 0) {
    status.summary(DiagnosticStatus::WARN, "not placed: " + map_.segments.back().refusal);
  } else if (last != nullptr && last->stamp >= map_.segments.back().start) {
    status.summary(DiagnosticStatus::WARN, "global positions contradict the path and are left out");
  }
  if (!failure_.empty()) status.summary(DiagnosticStatus::ERROR, failure_);
  status.add("frame", frame_of(map_, options_));
  status.add("stretches", map_.segments.size());
  status.add("stretches placed", placed);
  status.add("landmarks", map_.landmarks.size());
  status.add("landmarks of several local maps", map_.merged_landmarks);
  status.add("positions", map_.positions.size());
  status.add("positions in another frame", map_.ignored);
  status.add("positions left out", left_out);
  if (last == nullptr) return;
  status.addf("last left out (s)", "%.3f", to_seconds(last->stamp));
  status.add("last left out, measured", point_text(last->by_position));
  status.add("last left out, by the path", point_text(last->by_path));
}

}  // namespace kinect_ekf_slam
