#pragma once

#include <vector>

#include "kinect_ekf_slam/models/motion.h"
#include "kinect_ekf_slam/smoothing/calibration.h"
#include "kinect_ekf_slam/smoothing/recorded_run.h"

namespace kinect_ekf_slam {

/// What the odometry says of the motion between two times: after = before * delta * Exp(xi).
template <class Space>
struct Increment {
  using ByCalibration = Eigen::Matrix<double, Space::kPoseDim, kMotionUnknowns>;

  typename Space::Pose delta;
  typename Space::PoseMatrix covariance = Space::PoseMatrix::Zero();  ///< of xi
  ByCalibration by_calibration = ByCalibration::Zero();               ///< d xi / d calibration
};

/// The recorded velocities of a run as one motion, corrected by a calibration (docs/theory.md, section 12).
template <class Space>
class OdometryTrack {
 public:
  /// Keeps a reference to the velocities.
  OdometryTrack(const std::vector<RecordedVelocity>& velocities, const MotionOptions& noise)
      : velocities_(velocities), noise_(noise) {}

  void set_calibration(const MotionCalibration& calibration) { calibration_ = calibration; }
  const MotionCalibration& calibration() const { return calibration_; }

  /// From one time of the robot to a later one; the odometry's own times are earlier by the delay.
  Increment<Space> between(TimeNs from, TimeNs to) const;

 private:
  void append(const RecordedVelocity& held, double since_stamp, double dt, Increment<Space>* increment) const;
  typename Space::PoseVector calibrated_twist(const BodyVelocity& velocity) const;
  /// The last velocity whose stamp is not after `stamp`; the first when there is none.
  std::size_t index_at(TimeNs stamp) const;

  const std::vector<RecordedVelocity>& velocities_;
  MotionOptions noise_;
  MotionCalibration calibration_ = MotionCalibration::Zero();
};

}  // namespace kinect_ekf_slam
