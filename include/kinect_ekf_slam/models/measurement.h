#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// A sighting as the estimators take it: where the landmark is, seen from the robot, and how sure that is.
template <class Space>
struct Observation {
  typename Space::Point position_in_base = Space::Point::Zero();        ///< z, m
  typename Space::PointMatrix covariance = Space::PointMatrix::Zero();  ///< R, m^2
  double correlation_time =
      0.0;  ///< s over which errors of the same landmark's sightings resemble each other
  Signature signature;
  int detection = 0;  ///< which one of its time it is
};

/// How much less a sighting tells when the last one of the same landmark is `since_last` seconds ago and
/// their errors are correlated as exp(-t / correlation_time): the factor (1 + rho) / (1 - rho) on the
/// variance that a run of such errors needs to be treated as white. (docs/theory.md, section 3; the variance
/// of the mean of an AR(1) process.) One for the first sighting and for white noise, never infinite.
inline double correlation_inflation(double since_last, double correlation_time) {
  constexpr double kLargest = 1e4;
  if (!(correlation_time > 0.0)) return 1.0;
  const double rho = std::exp(-std::max(since_last, 0.0) / correlation_time);
  return std::min((1.0 + rho) / (1.0 - rho), kLargest);
}

/// R of a sighting of `landmark`, larger where it is unlikely (`robust_threshold`, 0: never) or says again
/// what the last sighting said. (docs/theory.md, sections 3 and 4.)
template <class Space>
typename Space::PointMatrix matched_noise(const Observation<Space>& observation, const LandmarkInfo& landmark,
                                          TimeNs stamp, double squared_distance, double robust_threshold) {
  const double echo = landmark.last_seen == 0 ? 1.0
                                              : correlation_inflation(to_seconds(stamp - landmark.last_seen),
                                                                      observation.correlation_time);
  const double doubt = robust_threshold > 0.0 ? std::max(1.0, squared_distance / robust_threshold) : 1.0;
  return std::max(echo, doubt) * observation.covariance;
}

/// z = pose^-1 * landmark, with its Jacobians (docs/theory.md, section 3).
template <class Space>
struct PredictedPoint {
  using Point = typename Space::Point;
  Point point_in_base;
  Eigen::Matrix<double, Space::kPointDim, Space::kPoseDim>
      by_pose;  ///< by a local perturbation pose * Exp(xi)
  typename Space::PointMatrix by_landmark;
};

template <class Space>
PredictedPoint<Space> predict_point(const typename Space::Pose& map_from_base,
                                    const typename Space::Point& landmark_in_map) {
  PredictedPoint<Space> predicted;
  predicted.by_landmark = map_from_base.rotation().transpose();
  predicted.point_in_base = predicted.by_landmark * (landmark_in_map - map_from_base.translation());
  predicted.by_pose = Space::point_by_pose(predicted.point_in_base);
  return predicted;
}

}  // namespace kinect_ekf_slam
