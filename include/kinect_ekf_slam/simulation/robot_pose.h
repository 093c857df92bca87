#pragma once

#include <Eigen/Geometry>
#include <variant>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// Where a simulated robot is. One that drives moves in SE(2) and so stays on the floor exactly, one that
/// flies moves in SE(3); the rest of the simulation sees a pose in three dimensions.
class RobotPose {
 public:
  RobotPose() = default;
  RobotPose(const Se2& pose) : pose_(pose) {}  // NOLINT(google-explicit-constructor): it is one
  RobotPose(const Se3& pose) : pose_(pose) {}  // NOLINT(google-explicit-constructor)

  bool is_spatial() const { return std::holds_alternative<Se3>(pose_); }

  /// Moves along a velocity held for one second. On the floor only what the floor allows counts.
  void move(const BodyVelocity& way) {
    if (auto* planar = std::get_if<Se2>(&pose_)) {
      *planar = *planar * Se2::exp(Planar::twist(way));
    } else {
      auto& spatial = std::get<Se3>(pose_);
      spatial = spatial * Se3::exp(Spatial::twist(way));
    }
  }

  Eigen::Isometry3d to_3d() const {
    const auto* planar = std::get_if<Se2>(&pose_);
    return planar != nullptr ? Planar::to_3d(*planar) : Spatial::to_3d(std::get<Se3>(pose_));
  }

 private:
  std::variant<Se2, Se3> pose_;
};

}  // namespace kinect_ekf_slam
