#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "kinect_ekf_slam/mapping/saved_state.h"
#include "kinect_ekf_slam/pipeline/options.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// One SensorFrame in, one SlamResult out; the only place that knows the order of the steps: condition the
/// inputs, predict, gate, give noise, associate, update.
class SlamPipeline {
 public:
  virtual ~SlamPipeline() = default;

  /// Frames come in the order of their stamps. A detection older than the estimate is refused as late.
  virtual SlamResult process(const SensorFrame& frame) = 0;

  /// Where the robot is at `stamp`, given frames that wait; changes nothing.
  virtual Pose3d look_ahead(const std::deque<SensorFrame>& waiting, TimeNs stamp) const = 0;

  virtual std::vector<Landmark3d> map() const = 0;
  /// The beacons of the list as they are known now, by their ids.
  virtual std::vector<Landmark3d> beacons() const = 0;

  virtual SavedState save() const = 0;
  /// Takes over the map, and the pose too if `keep_saved_pose`, else the present pose becomes independent of
  /// the new map. Throws std::invalid_argument, and nothing changes, when the state is of another space.
  virtual void load(const SavedState& state, bool keep_saved_pose) = 0;

  /// Puts the robot at a pose of the map.
  virtual void set_pose(const Pose3d& pose) = 0;
  virtual void set_mode(Mode mode) = 0;
  /// Forgets where the robot is, and looks for it in the map until it is found; until then sightings are
  /// `ambiguous`. Throws std::invalid_argument, and nothing changes, unless a map is loaded and not changed.
  virtual void relocalize() = 0;

  /// Takes what can be changed while running: the input, motion and sensor groups.
  virtual void set_live_options(const PipelineOptions& options) = 0;

  virtual const Eigen::Vector3d& gyro_bias() const = 0;
};

/// Throws std::invalid_argument when the options contradict each other.
std::unique_ptr<SlamPipeline> make_pipeline(const PipelineOptions& options);

}  // namespace kinect_ekf_slam
