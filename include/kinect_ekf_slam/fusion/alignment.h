#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/estimators/gaussian.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/estimators/pose_parts.h"
#include "kinect_ekf_slam/fusion/global_map_options.h"

namespace kinect_ekf_slam {

/// Places that are known in two frames. In the local frame they are linear in a vector of points s whose
/// errors may be correlated: place k is sum_j weights(k, j) s_j, as a spline gives it, and from there an
/// offset, as from the base to an antenna. In the global one they are independent.
template <class Space>
struct AlignmentPairs {
  Eigen::VectorXd local_points;      ///< s: the points one after the other, m, in the local frame
  Eigen::MatrixXd local_covariance;  ///< of s, m^2
  Eigen::MatrixXd weights;           ///< a row a pair, a column a point
  std::vector<Gaussian<Space::kPointDim>> offsets;    ///< m, m^2, in the local frame; empty: none
  std::vector<Gaussian<Space::kPointDim>> in_global;  ///< m, m^2; positive definite

  /// Point k and place k are one.
  static AlignmentPairs of_points(const std::vector<Gaussian<Space::kPointDim>>& in_local,
                                  const std::vector<Gaussian<Space::kPointDim>>& in_global);
};

/// What a compass and gravity say of how the local frame is turned.
template <class Space>
struct HeadingPrior {
  typename Space::Pose global_from_local;                        ///< its turn alone counts
  TurnMatrix<Space> covariance = TurnMatrix<Space>::Identity();  ///< rad^2, in the global frame's axes
};

/// Two estimates of one place that do not overlap.
template <class Space>
struct Disagreement {
  std::size_t pair = 0;
  Gaussian<Space::kPointDim> by_path;  ///< in the global frame
  Gaussian<Space::kPointDim> by_global_position;
  double squared_distance = 0.0;
};

/// Where the local frame lies in the global one, and what that says of the local points.
template <class Space>
struct Alignment {
  /// Errors in the global frame's axes, as everywhere.
  PoseEstimate<Space> global_from_local;
  Eigen::VectorXd local_points;                    ///< s, corrected by the global places
  Eigen::MatrixXd covariance;                      ///< of the transform's error, then that of s
  std::vector<Disagreement<Space>> disagreements;  ///< pairs that were left out
  double squared_distance = 0.0;  ///< of the pairs that were used, after the fit: chi-square with `dof`
  int dof = 0;
};

template <class Space>
struct AlignmentResult {
  std::optional<Alignment<Space>> alignment;
  std::string refusal;  ///< why there is none
};

/// The rigid transform (no scale) that brings the local places to the global ones, with its covariance
/// (docs/theory.md, section 13). It starts from the weighted closed form (Umeyama 1991), and ends in the
/// generalised least squares over transform and points, in which the noise of both sides and all correlations
/// count. A pair that does not overlap with what the others say is left out and told. Refused, with the
/// reason: fewer than two pairs (three in space), or places so near to one line that the turn about some axis
/// remains unknown; unless a heading prior says it.
template <class Space>
AlignmentResult<Space> align_frames(const AlignmentPairs<Space>& pairs, const AlignmentOptions& options,
                                    const std::optional<HeadingPrior<Space>>& heading = std::nullopt);

}  // namespace kinect_ekf_slam
