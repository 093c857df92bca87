#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "kinect_ekf_slam/estimators/gaussian_state.h"

namespace kinect_ekf_slam {

/// What regions that were left have yet to tell the covariance of the rest of the map: equation (9.8), whose
/// work grows with the map's square, done a few panels a step (docs/theory.md, section 9).
///
/// The covariance as stored and what is pending are together the true one: whoever reads the former asks
/// here for the rest.
template <class Space>
class PendingUpdates {
 public:
  static constexpr int kPointDim = Space::kPointDim;
  using PointMatrix = typename Space::PointMatrix;
  /// Steps over which an update is spread. More of them than this many at a time do not pile up.
  static constexpr int kSteps = 48;
  static constexpr int kMost = 3;

  /// P -= columns psi columns^T is to be done, `psi` symmetric.
  void add(Eigen::MatrixXd columns, Eigen::MatrixXd psi);
  /// These rows and columns of P, of the pose and some landmarks, are what they should be now.
  void settle(const std::vector<int>& landmarks);
  /// A slice of each update. The same calls do the same work, whatever time it takes.
  void advance(SymmetricMatrix* P);
  void finish(SymmetricMatrix* P);
  void clear() { updates_.clear(); }

  /// P's columns by the part, as GaussianState::columns() gives them, or one landmark's covariance: from what
  /// is stored to what is true.
  void correct_columns(const SymmetricMatrix& P, const std::vector<int>& landmarks,
                       Eigen::MatrixXd* columns) const;
  void correct_covariance(const SymmetricMatrix& P, int landmark, PointMatrix* covariance) const;

 private:
  struct Update {
    Eigen::MatrixXd columns;
    Eigen::MatrixXd psi;
    int done = 0;  ///< panels of P, from the top
  };
  static void advance(int panels, Update* update, SymmetricMatrix* P);

  std::deque<Update> updates_;  ///< oldest first
};

}  // namespace kinect_ekf_slam
