#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "kinect_ekf_slam/estimators/landmark_ids.h"
#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

/// The extended Kalman filter of the textbook (docs/theory.md, section 4).
///
/// State: pose and landmarks; error: position and landmarks in the map's axes, rotation local to the robot.
/// Only the lower triangle of the covariance is stored to be read, so it cannot become asymmetric.
template <class Space>
class Ekf : public SlamEstimator<Space> {
 public:
  Ekf(const EstimatorOptions& options, std::shared_ptr<const Associator<Space>> associator,
      const PoseEstimate<Space>& initial);

  void predict(const MotionStep<Space>& step) override;
  UpdateReport observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) override;
  PoseEstimate<Space> pose() const override;
  std::vector<LandmarkEstimate<Space>> landmarks() const override;
  SlamState<Space> snapshot() const override;
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override;
  void set_map_fixed(bool fixed) override { map_fixed_ = fixed; }
  std::unique_ptr<SlamEstimator<Space>> clone() const override { return std::make_unique<Ekf>(*this); }

 private:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseMatrix = typename Space::PoseMatrix;
  /// The rows of H that are not zero: by the pose, and by the one landmark seen.
  struct Jacobian {
    Eigen::Matrix<double, kPointDim, kPoseDim> by_pose;
    PointMatrix by_landmark;
  };
  struct Match {
    std::size_t observation;
    int landmark;
    double squared_distance;
  };
  class Prediction;

  int landmark_count() const { return static_cast<int>(infos_.size()); }
  int state_size() const { return kPoseDim + kPointDim * landmark_count(); }
  static int row(int landmark) { return kPoseDim + kPointDim * landmark; }
  Point landmark(int index) const { return landmarks_.template segment<kPointDim>(kPointDim * index); }

  Eigen::Block<Eigen::MatrixXd> covariance() { return covariance_.topLeftCorner(state_size(), state_size()); }
  PoseMatrix pose_covariance() const;
  PointMatrix landmark_covariance(int index) const;
  Jacobian jacobian(int index, Point* point_in_base) const;
  /// R of a match, larger where the sighting is unlikely or says again what the last one said.
  PointMatrix measurement_noise(TimeNs stamp, const Observation<Space>& observation,
                                const Match& match) const;
  PointMatrix predicted_covariance(int index, const Jacobian& jacobian) const;

  bool update(TimeNs stamp, const std::vector<Observation<Space>>& observations,
              const std::vector<Match>& matches, UpdateReport* report);
  void retract(const Eigen::Ref<const Eigen::VectorXd>& error);
  void add_landmark(TimeNs stamp, const Observation<Space>& observation);
  void remove_landmark(int index);
  void replace_if_contradicted(TimeNs stamp, const std::vector<Observation<Space>>& observations,
                               UpdateReport* report);

  EstimatorOptions options_;
  std::shared_ptr<const Associator<Space>> associator_;
  bool map_fixed_ = false;

  typename Space::Pose pose_;
  Eigen::VectorXd landmarks_;   ///< points one after the other
  Eigen::MatrixXd covariance_;  ///< capacity may exceed the state; the strict upper triangle is never read
  std::vector<LandmarkInfo> infos_;
  std::vector<int> contradictions_;  ///< of each landmark, refused sightings in a row
  LandmarkIds ids_;

  Eigen::MatrixXd cross_;  ///< P H^T, reused between updates
};

}  // namespace kinect_ekf_slam
