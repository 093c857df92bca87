#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinect_ekf_slam/estimators/gaussian_state.h"
#include "kinect_ekf_slam/estimators/pending_updates.h"

namespace kinect_ekf_slam {

/// What the filter of a part of the map means for the rest of it, kept until somebody asks (docs/theory.md,
/// section 9).
///
/// The part is the active one, a: the pose, and the landmarks that are filtered. All others are passive, b.
/// What was learnt in a is told to b at once and exactly, however many steps it took. Where nothing is
/// passive nothing is kept.
template <class Space>
class DeferredUpdate {
 public:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseMatrix = typename Space::PoseMatrix;
  using PointByPose = typename Space::PointByPose;

  /// Starts where `active` are the landmarks of a, out of `landmarks`, and `columns` those of P by a:
  /// equation (9.2).
  void start(int landmarks, const std::vector<int>& active, Eigen::MatrixXd columns);

  // What happens to the active part.
  void move(const PoseMatrix& F);                 ///< the robot moves: (9.3)
  void set_pose();                                ///< it is put somewhere, independent of the map
  void add_landmark(const PointByPose& by_pose);  ///< a landmark is new, at the end of a: (9.6)
  /// An update: (9.4) and (9.5). `weighted` is P_aa H^T L^-T, `whitened` L^-1 nu, `L_H_phi` L^-1 H phi. With
  /// a fixed map only the pose learns.
  void correct(const Eigen::Ref<const Eigen::MatrixXd>& weighted,
               const Eigen::Ref<const Eigen::VectorXd>& whitened,
               const Eigen::Ref<const Eigen::MatrixXd>& L_H_phi, bool map_fixed);

  /// How an error of the active part that was there at the start is found in it now.
  const Eigen::MatrixXd& phi() const { return phi_; }

  /// Brings `whole`, unchanged since the start, up to date by (9.7) and (9.9), and leaves (9.8) to `pending`.
  /// `active` may have grown by new landmarks, and `state` is a as it is now.
  void apply(const std::vector<int>& active, const GaussianState<Space>& state, GaussianState<Space>* whole,
             PendingUpdates<Space>* pending) const;

  // One passive landmark as it is now, from `whole` or its covariance as they were at the start.
  Point landmark(const GaussianState<Space>& whole, int index) const;
  PointMatrix landmark_covariance(const PointMatrix& at_start, int index) const;
  PointByPose landmark_by_pose(int index) const;
  /// No passive landmark has moved by more than this many standard deviations that it had at the start.
  double largest_shift() const;

 private:
  auto columns_of(int index) const {  // P_ba0 of a landmark
    return columns_.template middleRows<kPointDim>(GaussianState<Space>::row(index));
  }

  Eigen::MatrixXd columns_;  ///< P(:, a) at the start; of its rows those of b are P_ba0
  Eigen::MatrixXd start_;    ///< P_aa at the start
  Eigen::MatrixXd phi_;
  Eigen::MatrixXd psi_;  ///< lower triangle
  Eigen::VectorXd theta_;
};

}  // namespace kinect_ekf_slam
