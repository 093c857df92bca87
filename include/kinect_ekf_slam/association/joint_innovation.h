#pragma once

#include <Eigen/Core>
#include <optional>

#include "kinect_ekf_slam/association/associator.h"

namespace kinect_ekf_slam {

/// The innovation of several pairings of sightings with landmarks, grown by one pairing at a time.
///
/// Sightings of one time err together, because the pose errs: a pairing is likely or not given those already
/// made. The Cholesky factor of the joint covariance is bordered, so that a pairing more costs its own rows
/// only, and one taken back costs nothing (Neira and Tardos, IEEE Trans. Robotics and Automation 17(6),
/// 2001).
template <class Space>
class JointInnovation {
 public:
  explicit JointInnovation(const PredictedMap<Space>& map) : map_(&map) {}

  /// What one pairing adds, given those before it.
  struct Increment {
    double squared_distance;  ///< to the squared Mahalanobis distance of all
    double log_determinant;   ///< to that of the joint covariance
    /// Of the sighting, as the map and the pairings before foresee it.
    double log_likelihood() const;
  };

  /// Adds a pairing; nothing, and none is added, when the covariance is not positive definite.
  std::optional<Increment> push(const Observation<Space>& observation, int landmark);
  void pop();

  int size() const { return static_cast<int>(landmarks_.size()); }
  double squared_distance() const { return whitened_.head(rows()).squaredNorm(); }

 private:
  static constexpr int kDim = Space::kPointDim;
  int rows() const { return kDim * size(); }

  const PredictedMap<Space>* map_;
  std::vector<int> landmarks_;
  Eigen::MatrixXd L_;         ///< S = L L^T; its capacity may exceed the pairings
  Eigen::VectorXd whitened_;  ///< L^-1 nu
};

}  // namespace kinect_ekf_slam
