#include "kinect_ekf_slam/smoothing/smoothed_path.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace kinect_ekf_slam {

template <class Space>
PoseEstimate<Space> SmoothedPath<Space>::at(TimeNs stamp) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), stamp,
                                      [](TimeNs time, const Knot& knot) { return time < knot.stamp; });
  PoseEstimate<Space> estimate;
  PoseMatrix local;
  if (after == knots_.begin()) {  // backwards from the first knot
    const Increment<Space> gap = odometry_.between(stamp, after->stamp);
    const PoseMatrix back = gap.delta.adjoint();
    estimate.map_from_base = after->map_from_base * gap.delta.inverse();
    local = back * (after->covariance + gap.covariance) * back.transpose();
  } else {
    const Knot& before = *(after - 1);
    const Increment<Space> to_here = odometry_.between(before.stamp, stamp);
    const PoseMatrix here_from_before = to_here.delta.inverse().adjoint();
    estimate.map_from_base = before.map_from_base * to_here.delta;
    local = here_from_before * before.covariance * here_from_before.transpose() + to_here.covariance;
    if (after != knots_.end() && stamp > before.stamp) {
      // xi_here = F xi_before + K (xi_after - A xi_before) + w: docs/theory.md, equation (12.4).
      const Increment<Space> whole = odometry_.between(before.stamp, after->stamp);
      const PoseMatrix after_from_here = whole.delta.inverse().adjoint() * to_here.delta.adjoint();
      const PoseMatrix after_from_before = whole.delta.inverse().adjoint();
      const PoseMatrix gain = whole.covariance.ldlt().solve(after_from_here * to_here.covariance).transpose();
      const Pose error = whole.delta.inverse() * (before.map_from_base.inverse() * after->map_from_base);
      estimate.map_from_base = estimate.map_from_base * Pose::exp(gain * error.log());
      const PoseMatrix by_before = here_from_before - gain * after_from_before;
      const PoseMatrix cross = by_before * before.with_next * gain.transpose();
      local = by_before * before.covariance * by_before.transpose() + cross + cross.transpose() +
              gain * after->covariance * gain.transpose() + to_here.covariance -
              gain * whole.covariance * gain.transpose();
    }
  }
  const PoseMatrix map_from_local = error_from_local<Space>(estimate.map_from_base);
  estimate.covariance = map_from_local * local * map_from_local.transpose();
  estimate.covariance = 0.5 * (estimate.covariance + estimate.covariance.transpose()).eval();
  return estimate;
}

template class SmoothedPath<Planar>;
template class SmoothedPath<Spatial>;

}  // namespace kinect_ekf_slam
