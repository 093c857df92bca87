#include "kinect_ekf_slam/ros/slam_session.h"

#include <algorithm>
#include <utility>

namespace kinect_ekf_slam {
namespace {

FrameBuffer make_buffer(const SyncOptions& sync) {
  // IMU and odometry may both come as often as the queue allows, for the time that detections may be late.
  constexpr std::size_t kFramesPerSecond = 2000;
  const double seconds = std::max(sync.detection_delay, sync.position_delay) + 1.0;
  return {sync.detection_delay, static_cast<std::size_t>(kFramesPerSecond * seconds), sync.position_delay};
}

}  // namespace

SlamSession::SlamSession(const RunOptions& options, SensorBridge::TransformLookup lookup, Handlers handlers)
    : options_(options),
      handlers_(std::move(handlers)),
      pipeline_(make_pipeline(options.pipeline)),
      buffer_(make_buffer(options.sync)),
      bridge_(options.frames, options.sync, std::move(lookup),
              {[this](SensorFrame frame) { process(buffer_.add(std::move(frame))); },
               [this] {
                 reset();
                 if (handlers_.on_time_jump) handlers_.on_time_jump();
               },
               handlers_.on_refusal},
              options.fusion) {}

void SlamSession::process(const std::vector<SensorFrame>& frames) {
  for (const SensorFrame& frame : frames) {
    const SlamResult result = pipeline_->process(frame);
    newest_ = result.pose.stamp;
    handlers_.on_result(frame, result);
  }
}

TimeNs SlamSession::newest() const {
  return buffer_.waiting().empty() ? newest_ : buffer_.waiting().back().stamp;
}

void SlamSession::flush() { process(buffer_.flush()); }

void SlamSession::set_pose(const Pose3d& pose) {
  flush();
  pipeline_->set_pose(pose);
}

void SlamSession::relocalize() {
  flush();
  pipeline_->relocalize();
}

void SlamSession::load(const SavedState& state, bool keep_saved_pose) {
  flush();
  pipeline_->load(state, keep_saved_pose);
  fixed_map_ = state;
}

void SlamSession::set_mode(Mode mode) {
  if (mode == Mode::kLocalization && options_.pipeline.mode != mode) fixed_map_ = pipeline_->save();
  options_.pipeline.mode = mode;
  pipeline_->set_mode(mode);
}

void SlamSession::set_live_options(const PipelineOptions& options) {
  options_.pipeline.input = options.input;
  options_.pipeline.motion = options.motion;
  options_.pipeline.sensor = options.sensor;
  pipeline_->set_live_options(options_.pipeline);
}

void SlamSession::reset() {
  pipeline_ = make_pipeline(options_.pipeline);
  if (options_.pipeline.mode == Mode::kLocalization && fixed_map_) pipeline_->load(*fixed_map_, false);
  buffer_ = make_buffer(options_.sync);
  newest_ = 0;
  bridge_.reset();
}

}  // namespace kinect_ekf_slam
