#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"
#include "kinect_ekf_slam/estimators/symmetric_matrix.h"

namespace kinect_ekf_slam {

/// Mean and covariance of a pose and a growing number of landmarks: the state of every Kalman estimator.
///
/// Error: position, rotation and landmarks in the map's axes (docs/theory.md, section 4). Only the lower
/// triangle of the covariance is stored, so it cannot become asymmetric.
template <class Space>
class GaussianState {
 public:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseMatrix = typename Space::PoseMatrix;
  using PointByPose = typename Space::PointByPose;

  explicit GaussianState(const PoseEstimate<Space>& initial);

  int landmark_count() const { return static_cast<int>(infos_.size()); }
  int size() const { return row(landmark_count()); }
  /// First row of a landmark's error; the pose's rows come before the landmarks'.
  static constexpr int row(int landmark) { return kPoseDim + kPointDim * landmark; }

  const Pose& map_from_base() const { return pose_; }
  PoseMatrix pose_covariance() const { return covariance_.block<kPoseDim, kPoseDim>(0, 0); }
  const Point& landmark(int index) const { return points_[index]; }
  PointMatrix landmark_covariance(int index) const { return landmark_covariance(index, index); }
  /// Covariance of two landmarks' errors, the first by the second.
  PointMatrix landmark_covariance(int a, int b) const {
    return covariance_.block<kPointDim, kPointDim>(row(a), row(b));
  }
  PointByPose landmark_by_pose(int index) const {
    return covariance_.block<kPointDim, kPoseDim>(row(index), 0);
  }
  LandmarkInfo& info(int index) { return infos_[index]; }
  const LandmarkInfo& info(int index) const { return infos_[index]; }
  std::vector<LandmarkEstimate<Space>> landmarks() const;

  void set_map_from_base(const Pose& map_from_base) { pose_ = map_from_base; }
  void set_landmark(int index, const Point& landmark_in_map) { points_[index] = landmark_in_map; }
  SymmetricMatrix& covariance() { return covariance_; }
  const SymmetricMatrix& covariance() const { return covariance_; }

  // A part of the state: the pose and some landmarks, given by their indices. Its rows are in that order.
  /// Calls visit(row in the state, row in the part, number of rows) for the pose and for each landmark.
  template <class Visit>
  static void for_each_block(const std::vector<int>& landmarks, const Visit& visit);
  /// P's columns by the part, of all its rows.
  Eigen::MatrixXd columns(const std::vector<int>& landmarks) const;
  void set_columns(const std::vector<int>& landmarks, const Eigen::MatrixXd& columns);
  /// The part alone, given P's columns by it.
  GaussianState marginal(const std::vector<int>& landmarks, const Eigen::MatrixXd& columns) const;

  /// The robot moves, the landmarks stand still: equation (4.4), F the Jacobian of `moved` by the pose.
  void move(const PoseEstimate<Space>& moved, const PoseMatrix& F);
  /// P -= U U^T, of which the second changes the pose's rows and columns alone: equations (4.9) and (4.10).
  void correct(const Eigen::Ref<const Eigen::MatrixXd>& U);
  void correct_pose(const Eigen::Ref<const Eigen::MatrixXd>& U);
  /// Puts the robot somewhere, independent of the map.
  void set_pose(const PoseEstimate<Space>& pose);
  /// A landmark that depends on the pose: its error is `by_pose` times the pose's plus an independent one.
  void add_landmark(LandmarkInfo info, const Point& landmark_in_map, const PointByPose& by_pose,
                    const PointMatrix& independent);
  /// Forgets a landmark: what it said of the others stays with them.
  void remove_landmark(int index);

  SlamState<Space> snapshot() const;
  void restore(const SlamState<Space>& state);

 private:
  Pose pose_;
  std::vector<Point> points_;  ///< m, in the map
  SymmetricMatrix covariance_;
  std::vector<LandmarkInfo> infos_;
};

template <class Space>
template <class Visit>
void GaussianState<Space>::for_each_block(const std::vector<int>& landmarks, const Visit& visit) {
  visit(0, 0, kPoseDim);
  for (std::size_t j = 0; j < landmarks.size(); ++j) {
    visit(row(landmarks[j]), row(static_cast<int>(j)), kPointDim);
  }
}

}  // namespace kinect_ekf_slam
