#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/landmark_3d.h"
#include "kinect_ekf_slam/pipeline/options.h"
#include "kinect_ekf_slam/pipeline/pose_3d.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"

namespace kinect_ekf_slam {

/// One map and one path in the frame of global positions, in three dimensions, whatever space they were
/// estimated in.
struct GlobalMap3d {
  /// A global position and the path at its time, that contradict each other.
  struct Contradiction {
    TimeNs stamp = 0;
    Eigen::Vector3d by_path = Eigen::Vector3d::Zero();  ///< m
    Eigen::Vector3d by_position = Eigen::Vector3d::Zero();
    double squared_distance = 0.0;  ///< Mahalanobis
  };
  /// A stretch of the way, see GlobalSegment.
  struct Segment {
    int first_map = 0;
    int last_map = 0;
    TimeNs start = 0;
    TimeNs end = 0;
    std::string refusal;       ///< why it could not be placed; empty: it was
    Pose3d global_from_local;  ///< of the robot at `start`, where the local frame is
    std::size_t positions = 0;
    std::vector<Contradiction> left_out;
    std::vector<Pose3d> path;  ///< empty unless placed
  };
  /// As it was measured.
  struct Position {
    TimeNs stamp = 0;
    Eigen::Vector3d antenna = Eigen::Vector3d::Zero();  ///< m
  };

  bool positions_in_map = false;      ///< the frame is frames/map, else fusion/frame
  std::vector<Landmark3d> landmarks;  ///< confirmed ones, in the global frame
  std::vector<Segment> segments;
  std::vector<Position> positions;  ///< all that were taken
  std::size_t ignored = 0;          ///< positions in the other one of the two frames
  int merged_landmarks = 0;         ///< that stood in several local maps
};

/// Several sensors and one globally consistent map, the source's algorithm 3 (docs/theory.md, section 13):
/// SLAM in one local map after the other, and beside it, not in the filter, global positions; then all of it
/// in one frame. It takes the frames that the pipeline takes.
///
/// Positions come from one frame, the one that the first of them is in; ranges to beacons that are known well
/// tell positions in the map's. Of those that come often, one is kept each LocalMapOptions::path_interval.
class GlobalMapper {
 public:
  virtual ~GlobalMapper() = default;

  /// Lines 1 to 15. Frames come in the order of their stamps; what is late is ignored.
  virtual void add(const SensorFrame& frame) = 0;

  /// The robot was carried, or told that it is elsewhere: the path breaks off, and a new one starts.
  virtual void break_path() = 0;

  /// Lines 16 to 22, on all that has come so far. The work is done where the function is called, and needs
  /// nothing of the mapper: another thread may call it.
  virtual std::function<GlobalMap3d()> integration() const = 0;
};

/// Throws std::invalid_argument when the options contradict each other: the estimator is no Kalman filter.
std::unique_ptr<GlobalMapper> make_global_mapper(const PipelineOptions& options);

}  // namespace kinect_ekf_slam
