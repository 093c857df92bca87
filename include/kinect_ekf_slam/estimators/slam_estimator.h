#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/models/measurement.h"
#include "kinect_ekf_slam/models/motion.h"
#include "kinect_ekf_slam/models/pose_measurement.h"

namespace kinect_ekf_slam {

template <class Space>
struct LandmarkEstimate {
  LandmarkInfo info;
  typename Space::Point position_in_map = Space::Point::Zero();         ///< m
  typename Space::PointMatrix covariance = Space::PointMatrix::Zero();  ///< m^2, marginal
};

/// All that an estimator knows. Row order of the covariance: pose (position, rotation), then the landmarks.
template <class Space>
struct SlamState {
  typename Space::Pose map_from_base;
  std::vector<LandmarkInfo> infos;
  Eigen::VectorXd landmarks_in_map;  ///< m, the points one after the other
  Eigen::MatrixXd covariance;        ///< symmetric, of size pose dim + point dim * landmarks
};

/// A sighting of an earlier time turned out to be something else.
struct Revision {
  TimeNs stamp = 0;
  int detection = 0;      ///< as the observation calls itself
  Assignment assignment;  ///< `landmark` is the landmark's id
};

/// What became of the observations of one time.
struct UpdateReport {
  std::vector<Assignment>
      assignments;  ///< one an observation; `landmark` is the landmark's id, not its index
  double nis = std::numeric_limits<double>::quiet_NaN();  ///< nu^T S^-1 nu of the joint update, before it
  int dof = 0;                                            ///< of the joint update, 0: none took place

  // Whether the robot is where it believes to be, beside the assignments.
  int provisional = 0;  ///< matches of landmarks that are not believed in yet: they say nothing
  double missed = 0.0;  ///< sum of the detection rates of the believed landmarks that were looked for in vain

  // What it did to the map, and to what was believed before; landmarks by their ids.
  std::vector<int> confirmed;
  std::vector<int> removed;                 ///< nothing stands there
  std::vector<std::pair<int, int>> merged;  ///< the first is the second
  std::vector<Revision> revisions;
};

/// What became of a measurement of where the robot is.
struct LocateReport {
  PositionVerdict verdict = PositionVerdict::kUnsupported;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> innovation{};      ///< nu, before it was used
  double squared_distance = std::numeric_limits<double>::quiet_NaN();  ///< nu^T S^-1 nu, likewise
  double log_likelihood = std::numeric_limits<double>::quiet_NaN();    ///< log N(nu; 0, S)
};

/// The contract of every SLAM estimator: predict, observe, and say what you believe.
///
/// Estimates are in the map frame. After any call the covariances are symmetric and positive semi-definite.
template <class Space>
class SlamEstimator {
 public:
  virtual ~SlamEstimator() = default;

  /// Moves the robot.
  virtual void predict(const MotionStep<Space>& step) = 0;

  /// Associates all observations of one time, corrects pose and map in one joint update, adds new landmarks.
  virtual UpdateReport observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) = 0;

  // What else tells where the robot is: of the Kalman filters only.
  /// Takes in a measurement of the pose, or of the pose and the landmark with this id (kNoId: none), if its
  /// squared distance is below `gate`.
  virtual LocateReport locate(const PoseMeasurement<Space>& /*measurement*/, int /*landmark_id*/,
                              double /*gate*/) {
    return {};
  }
  /// A landmark that nobody sees stands here, as a list says, give or take `covariance`. Its id is new.
  virtual void add_landmark(int /*id*/, const typename Space::Point& /*position_in_map*/,
                            const typename Space::PointMatrix& /*covariance*/) {}
  /// Robot and map together may lie elsewhere: moved as one rigid body by a shift and a turn about the map's
  /// origin with this covariance.
  virtual void loosen(const typename Space::PoseMatrix& /*covariance*/) {}

  virtual PoseEstimate<Space> pose() const = 0;
  virtual std::vector<LandmarkEstimate<Space>> landmarks() const = 0;

  /// The whole state; `restore(snapshot())` changes nothing.
  virtual SlamState<Space> snapshot() const = 0;
  virtual void restore(const SlamState<Space>& state) = 0;

  /// Puts the robot somewhere, independent of all that the map knows; the map stays.
  virtual void set_pose(const PoseEstimate<Space>& pose) = 0;

  /// With a fixed map the landmarks and their covariance never change and none is added; their uncertainty is
  /// still accounted for in the pose's.
  virtual void set_map_fixed(bool fixed) = 0;

  virtual std::unique_ptr<SlamEstimator> clone() const = 0;
};

}  // namespace kinect_ekf_slam
