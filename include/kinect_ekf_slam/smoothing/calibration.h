#pragma once

#include <Eigen/Core>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// Of the odometry: corrections to what the run was configured with.
enum MotionUnknown { kLogLinearScale, kLogAngularScale, kDelay, kMotionUnknowns };
/// Of the sensor; then follow the corrections of its place and of its attitude, in the axes of the base.
enum SensorUnknown { kLogRangeScale, kDepthShare, kMounting };

template <class Space>
constexpr int kSensorUnknowns = kMounting + Space::kPoseDim;

using MotionCalibration = Eigen::Matrix<double, kMotionUnknowns, 1>;
template <class Space>
using SensorCalibration = Eigen::Matrix<double, kSensorUnknowns<Space>, 1>;

/// What is not known of a robot before a run (docs/theory.md, section 12). All but the share are zero when
/// the configuration is right.
template <class Space>
struct Calibration {
  static constexpr int kUnknowns = kMotionUnknowns + kSensorUnknowns<Space>;

  MotionCalibration motion = MotionCalibration::Zero();  ///< -, -, s
  /// -, - (the share itself), then m and rad.
  SensorCalibration<Space> sensor = SensorCalibration<Space>::Zero();
};

/// Standard deviations of what may differ from the configuration.
struct CalibrationPrior {
  double scale = 0.03;        ///< of the speed and the turn rate
  double delay = 0.1;         ///< s, of the odometry
  double range_scale = 0.01;  ///< tight: the odometry's scale alone cannot tell how large the world is
  double depth_share = 0.5;
  double place = 0.02;         ///< m, of the sensor along each axis
  double turn = radians(3.0);  ///< rad, of the sensor about each axis
};

template <class Space>
Calibration<Space> sigmas(const CalibrationPrior& prior) {
  Calibration<Space> sigmas;
  sigmas.motion << prior.scale, prior.scale, prior.delay;
  sigmas.sensor.setConstant(prior.turn);
  sigmas.sensor.template segment<Space::kPointDim>(kMounting).setConstant(prior.place);
  sigmas.sensor(kLogRangeScale) = prior.range_scale;
  sigmas.sensor(kDepthShare) = prior.depth_share;
  return sigmas;
}

}  // namespace kinect_ekf_slam
