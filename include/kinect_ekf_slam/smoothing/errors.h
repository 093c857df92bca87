#pragma once

#include "kinect_ekf_slam/smoothing/calibration.h"
#include "kinect_ekf_slam/smoothing/differentiable_pose.h"
#include "kinect_ekf_slam/smoothing/odometry_track.h"

namespace kinect_ekf_slam {

// The whitened errors of docs/theory.md, section 12, as Ceres differentiates them. Poses are the numbers of
// Space::to_vector. Errors in metres are those of what was measured, before any scale: else a smaller world
// would have smaller errors.

/// Odometry between two poses against what it should have said.
template <class Space>
struct MotionError {
  Increment<Space> increment;
  MotionCalibration linearized_at;  ///< the calibration that the increment was made with
  typename Space::PoseMatrix whitening;

  template <class T>
  bool operator()(const T* before, const T* after, const T* calibration, T* residual) const {
    using Pose = DifferentiablePose<Space, T>;
    using std::exp;
    const Eigen::Map<const Eigen::Matrix<T, kMotionUnknowns, 1>> unknowns(calibration);
    const Eigen::Matrix<T, kMotionUnknowns, 1> change = unknowns - linearized_at.template cast<T>();
    const Eigen::Matrix<T, Space::kPoseDim, 1> xi = increment.by_calibration.template cast<T>() * change;
    const Pose predicted = Pose::from(increment.delta) * Pose::small(xi);
    Eigen::Matrix<T, Space::kPoseDim, 1> error =
        (predicted.inverse() * (Pose::from_numbers(before).inverse() * Pose::from_numbers(after))).as_small();
    error.template head<Space::kPointDim>() *= exp(-change(kLogLinearScale));
    Eigen::Map<Eigen::Matrix<T, Space::kPoseDim, 1>>{residual} = whitening.template cast<T>() * error;
    return true;
  }
};

/// Where a landmark was seen against where it should have been: along the ray and across it.
template <class Space>
struct SightingError {
  typename Space::Point seen;    ///< from the sensor, in the axes of the base, corrected as configured; m
  typename Space::Point sensor;  ///< in the base, m
  double obliquity = 0.0;
  double configured_share = 0.0;
  double mean_obliquity = 0.0;  ///< of the run
  typename Space::PointMatrix whitening;

  template <class T>
  bool operator()(const T* pose, const T* landmark, const T* calibration, T* residual) const {
    using Pose = DifferentiablePose<Space, T>;
    using Point = typename Pose::Point;
    const Eigen::Map<const Eigen::Matrix<T, kSensorUnknowns<Space>, 1>> unknowns(calibration);
    const Pose mounting = Pose::small(unknowns.template tail<Space::kPoseDim>());
    const Point landmark_in_base =
        Pose::from_numbers(pose).inverse() * Point(Eigen::Map<const Point>(landmark));
    const Point expected = mounting.inverse() * Point(landmark_in_base - sensor.template cast<T>());
    const T distance = expected.norm();
    const double range = seen.norm();
    const Point ray = (seen / range).template cast<T>();
    // The error across is an angle times what was measured, so it does not shrink with the world.
    const Point error =
        T(range) * (expected / distance - ray) + (distance / factor(calibration) - T(range)) * ray;
    Eigen::Map<Point>{residual} = whitening.template cast<T>() * error;
    return true;
  }

  /// True distance over the configured one. Whatever the share, the scale is that of the run's mean sighting:
  /// this is what the configured one was found for.
  template <class T>
  T factor(const T* calibration) const {
    using std::exp;
    const T& share = calibration[kDepthShare];
    return exp(calibration[kLogRangeScale]) * (1.0 + share * obliquity) / (1.0 + share * mean_obliquity) *
           ((1.0 + configured_share * mean_obliquity) / (1.0 + configured_share * obliquity));
  }
};

/// The first pose against where the run began.
template <class Space>
struct StartError {
  typename Space::Pose map_from_start;
  typename Space::PoseMatrix whitening;  ///< of errors in the axes of the start

  template <class T>
  bool operator()(const T* pose, T* residual) const {
    using Pose = DifferentiablePose<Space, T>;
    const Eigen::Matrix<T, Space::kPoseDim, 1> error =
        (Pose::from(map_from_start).inverse() * Pose::from_numbers(pose)).as_small();
    Eigen::Map<Eigen::Matrix<T, Space::kPoseDim, 1>>{residual} = whitening.template cast<T>() * error;
    return true;
  }
};

}  // namespace kinect_ekf_slam
