#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "kinect_ekf_slam/pipeline/frame_buffer.h"
#include "kinect_ekf_slam/pipeline/slam_pipeline.h"
#include "kinect_ekf_slam/ros/run_options.h"
#include "kinect_ekf_slam/ros/sensor_bridge.h"

namespace kinect_ekf_slam {

/// One run from messages to results: bridge, buffer and pipeline. `slam_node` feeds it from subscriptions,
/// `slam_replay` from a bag; both get the same results.
class SlamSession {
 public:
  struct Handlers {
    std::function<void(const SensorFrame&, const SlamResult&)> on_result;
    std::function<void()> on_time_jump;  ///< after everything was reset
    std::function<void(const std::string&)> on_refusal;
  };

  SlamSession(const RunOptions& options, SensorBridge::TransformLookup lookup, Handlers handlers);

  SensorBridge& input() { return bridge_; }
  const SensorBridge& input() const { return bridge_; }
  SlamPipeline& pipeline() { return *pipeline_; }
  const SlamPipeline& pipeline() const { return *pipeline_; }

  /// The robot's pose at `stamp`, with the odometry that still waits for detections of its time.
  Pose3d pose_at(TimeNs stamp) const { return pipeline_->look_ahead(buffer_.waiting(), stamp); }

  /// The newest time that a result or a waiting frame speaks of.
  TimeNs newest() const;

  /// Puts the robot at a pose of the map as of now: odometry that waits is history.
  void set_pose(const Pose3d& pose);

  /// Replaces the map, now and after every reset when in localisation mode. Throws as SlamPipeline::load
  /// does.
  void load(const SavedState& state, bool keep_saved_pose);
  void set_mode(Mode mode);
  /// Looks for the robot in the map from now on: odometry that waits is history. Throws as
  /// SlamPipeline::relocalize does.
  void relocalize();
  void set_live_options(const PipelineOptions& options);

  /// A new run: pose, map, waiting frames and half-formed triples are forgotten; a fixed map stays.
  void reset();

  /// Processes what still waits: the end of a bag.
  void flush();

 private:
  void process(const std::vector<SensorFrame>& frames);

  RunOptions options_;
  Handlers handlers_;
  std::optional<SavedState> fixed_map_;
  std::unique_ptr<SlamPipeline> pipeline_;
  FrameBuffer buffer_;
  TimeNs newest_ = 0;
  SensorBridge bridge_;
};

}  // namespace kinect_ekf_slam
