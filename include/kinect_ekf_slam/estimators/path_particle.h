#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/estimators/gaussian.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/estimators/shared_array.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"
#include "kinect_ekf_slam/models/measurement.h"

namespace kinect_ekf_slam {

/// FastSLAM's particle: a path, and one small Kalman filter a landmark (docs/filters.md).
///
/// The path is known up to the pose that was drawn last. What came since is Gaussian: the pose and the
/// landmarks seen since then, the window, are one joint Kalman filter. Drawing the pose makes all landmarks
/// independent again, and empties the window. Copies share what they have in common of the map.
template <class Space>
class PathParticle {
 public:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseVector = typename Space::PoseVector;
  using PoseMatrix = typename Space::PoseMatrix;
  using Landmark = Gaussian<kPointDim>;     ///< in the map, given the path
  using Expectation = Gaussian<kPointDim>;  ///< of a sighting, in the base

  PathParticle() = default;
  /// Of all that an estimator knows, its landmark i the track i; nothing is drawn yet.
  explicit PathParticle(const SlamState<Space>& state);

  PoseEstimate<Space> pose() const {
    return {map_from_base_, covariance_.template topLeftCorner<kPoseDim, kPoseDim>()};
  }
  /// Null: the particle has none of this number.
  const Landmark* landmark(int track) const { return map_.find(track); }
  /// Landmarks whose errors depend on the pose's.
  const std::vector<int>& window() const { return window_; }
  /// Of the errors of the pose and then of the window's landmarks, in the map's axes.
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  static constexpr int row(std::size_t place_in_window) {
    return kPoseDim + kPointDim * static_cast<int>(place_in_window);
  }

  /// Puts the robot somewhere, independent of the map, and surely.
  void set_pose(const Pose& map_from_base);
  void move(const MotionStep<Space>& step);
  /// Where a landmark is expected to be seen, and how surely, H P H^T.
  Expectation expected(int track) const;

  struct Sighting {
    int track;
    Point position_in_base;  ///< m
    PointMatrix noise;       ///< m^2
  };
  /// The Kalman update by sightings of one time: all are linearised at the same state, their order does not
  /// matter. How well each fitted, the others before it taken in; nothing, and unused, when its S is
  /// singular.
  std::vector<std::optional<Fit>> correct(const std::vector<Sighting>& sightings);
  /// Puts a landmark where it is seen, whether there is one of this number or not.
  void place(int track, const Observation<Space>& observation);
  /// Draws the pose, by standard normal numbers, and tells the window's landmarks.
  void draw(const PoseVector& white);

 private:
  /// What a sighting of a landmark says: the point and its derivatives by the errors of pose and landmark.
  PredictedPoint<Space> predict(int track) const;
  /// First row of a landmark of the window, -1: it is not there.
  int find_row(int track) const;
  /// The same; the landmark joins the window.
  int join(int track);
  /// Moves the estimate by an error of pose and window.
  void retract(const Eigen::VectorXd& error);

  Pose map_from_base_;
  std::vector<int> window_;
  Eigen::MatrixXd covariance_ = PoseMatrix::Zero();
  SharedArray<Landmark> map_;  ///< also the window's, with their marginal covariances
};

}  // namespace kinect_ekf_slam
