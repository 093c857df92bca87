#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

/// Mean and covariance of a pose and a growing number of landmarks: the state of every Kalman estimator.
///
/// Error: position, rotation and landmarks in the map's axes (docs/theory.md, section 4). Only the lower
/// triangle of the covariance is stored to be read, so it cannot become asymmetric.
template <class Space>
class GaussianState {
 public:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseMatrix = typename Space::PoseMatrix;

  explicit GaussianState(const PoseEstimate<Space>& initial);

  int landmark_count() const { return static_cast<int>(infos_.size()); }
  int size() const { return row(landmark_count()); }
  /// First row of a landmark's error; the pose's rows come before the landmarks'.
  static constexpr int row(int landmark) { return kPoseDim + kPointDim * landmark; }

  const Pose& map_from_base() const { return pose_; }
  PoseMatrix pose_covariance() const;
  Point landmark(int index) const { return points_.template segment<kPointDim>(kPointDim * index); }
  PointMatrix landmark_covariance(int index) const { return landmark_covariance(index, index); }
  /// Covariance of two landmarks' errors, the first by the second.
  PointMatrix landmark_covariance(int a, int b) const;
  typename Space::PointByPose landmark_by_pose(int index) const {
    return covariance_.template block<kPointDim, kPoseDim>(row(index), 0);
  }
  LandmarkInfo& info(int index) { return infos_[index]; }
  const LandmarkInfo& info(int index) const { return infos_[index]; }
  std::vector<LandmarkEstimate<Space>> landmarks() const;

  void set_map_from_base(const Pose& map_from_base) { pose_ = map_from_base; }
  void set_landmark(int index, const Point& landmark_in_map) {
    points_.template segment<kPointDim>(kPointDim * index) = landmark_in_map;
  }
  /// The covariance's lower triangle; what stands above the diagonal is never read.
  Eigen::Block<Eigen::MatrixXd> lower() { return covariance_.topLeftCorner(size(), size()); }
  Eigen::Block<const Eigen::MatrixXd> lower() const { return covariance_.topLeftCorner(size(), size()); }
  /// columns += P.middleCols(start, weights.rows()) * weights.
  template <class Weights>
  void add_weighted_columns(int start, const Weights& weights, Eigen::Ref<Eigen::MatrixXd> columns) const;

  // A part of the state: the pose and some landmarks, given by their indices. Its rows are in that order.
  /// Calls visit(row in the state, row in the part, number of rows) for the pose and for each landmark.
  template <class Visit>
  static void for_each_block(const std::vector<int>& landmarks, const Visit& visit);
  /// P's columns by the part, of all its rows.
  Eigen::MatrixXd columns(const std::vector<int>& landmarks) const;
  void set_columns(const std::vector<int>& landmarks, const Eigen::MatrixXd& columns);
  GaussianState marginal(const std::vector<int>& landmarks) const;

  /// The robot moves, the landmarks stand still: equation (4.4), F the Jacobian of `moved` by the pose.
  void move(const PoseEstimate<Space>& moved, const PoseMatrix& F);
  /// Puts the robot somewhere, independent of the map.
  void set_pose(const PoseEstimate<Space>& pose);
  /// A landmark that depends on the pose: its error is `by_pose` times the pose's plus an independent one.
  void add_landmark(LandmarkInfo info, const Point& landmark_in_map,
                    const typename Space::PointByPose& by_pose, const PointMatrix& independent);
  /// Forgets a landmark: what it said of the others stays with them.
  void remove_landmark(int index);

  SlamState<Space> snapshot() const;
  void restore(const SlamState<Space>& state);

 private:
  Pose pose_;
  Eigen::VectorXd points_;      ///< m, in the map, one after the other
  Eigen::MatrixXd covariance_;  ///< capacity may exceed the state
  std::vector<LandmarkInfo> infos_;
};

template <class Space>
template <class Weights>
void GaussianState<Space>::add_weighted_columns(int start, const Weights& weights,
                                                Eigen::Ref<Eigen::MatrixXd> columns) const {
  const auto P = lower();
  const auto count = weights.rows();
  const auto below = P.rows() - start - count;
  columns.topRows(start).noalias() += P.block(start, 0, count, start).transpose() * weights;
  columns.middleRows(start, count).noalias() +=
      P.block(start, start, count, count).template selfadjointView<Eigen::Lower>() * weights;
  columns.bottomRows(below).noalias() += P.block(start + count, start, below, count) * weights;
}

template <class Space>
template <class Visit>
void GaussianState<Space>::for_each_block(const std::vector<int>& landmarks, const Visit& visit) {
  visit(0, 0, kPoseDim);
  for (std::size_t j = 0; j < landmarks.size(); ++j) {
    visit(row(landmarks[j]), row(static_cast<int>(j)), kPointDim);
  }
}

}  // namespace kinect_ekf_slam
