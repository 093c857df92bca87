#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/pipeline/landmark_3d.h"
#include "kinect_ekf_slam/pipeline/pose_3d.h"

namespace kinect_ekf_slam {

/// What became of one detection.
struct DetectionOutcome {
  int source_id = kNoId;
  Verdict verdict = Verdict::kInvalid;
  int landmark_id = kNoId;
  double nis = std::numeric_limits<double>::quiet_NaN();  ///< squared Mahalanobis distance to that landmark
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();  ///< m, seen from the corrected pose
};

/// What an earlier detection has turned out to be.
struct RevisedOutcome {
  TimeNs stamp = 0;
  int detection = 0;  ///< index in its message
  Verdict verdict = Verdict::kInvalid;
  int landmark_id = kNoId;
  double nis = std::numeric_limits<double>::quiet_NaN();
};

/// What became of a position or a range.
struct PositionOutcome {
  PositionVerdict verdict = PositionVerdict::kInvalid;
  int beacon = kNoId;                                     ///< kNoId: a position
  double nis = std::numeric_limits<double>::quiet_NaN();  ///< squared Mahalanobis distance to the estimate
  int dof = 0;
  /// m, of the antenna as measured; not a number where it is not known in the map, and of a range.
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

/// Whether it is known where the robot is in the map.
enum class Localization {
  kTracking,   ///< the pose is followed
  kSearching,  ///< unknown: the pose that is told means nothing, and its covariance says so
  kFound,      ///< followed again, after a search
  kLost,  ///< most of what is seen fits no landmark, or positions and ranges contradict: not to be trusted
};

/// What the pipeline made of one frame.
struct SlamResult {
  Pose3d pose;
  Eigen::Isometry3d dead_reckoned = Eigen::Isometry3d::Identity();  ///< the same run without any correction
  bool looked = false;                               ///< the frame carried detections, perhaps none
  std::vector<DetectionOutcome> outcomes;            ///< one a detection, in their order
  std::vector<RevisedOutcome> revisions;             ///< of earlier frames
  std::vector<PositionOutcome> positions;            ///< of what told where the robot is
  std::optional<Eigen::Isometry3d> map_from_global;  ///< the frame of global positions, once it is known
  std::vector<int> removed;                          ///< landmarks that were taken off: nothing is there
  std::vector<std::pair<int, int>> merged;           ///< landmarks: the first turned out to be the second
  double nis = std::numeric_limits<double>::quiet_NaN();  ///< of the joint update
  int dof = 0;
  Localization localization = Localization::kTracking;
  bool finite = true;  ///< false: the estimate broke down and nothing of it may be used
};

}  // namespace kinect_ekf_slam
