#include "kinect_ekf_slam/smoothing/odometry_track.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/models/held_motion.h"

namespace kinect_ekf_slam {
namespace {

/// Variance per second, m^2 and rad^2, that even a standing robot has: no two poses are exactly alike.
constexpr double kLeastDensity = 1e-8;

/// Integral of Ad(Exp(-s twist)) over s in [0, 1], two Gauss-Legendre nodes: a change of the twist seen from
/// the end of the arc.
template <class Space>
typename Space::PoseMatrix right_jacobian(const typename Space::PoseVector& twist) {
  const double offset = 0.5 / std::sqrt(3.0);
  return 0.5 * (Space::Pose::exp(-(0.5 - offset) * twist).adjoint() +
                Space::Pose::exp(-(0.5 + offset) * twist).adjoint());
}

}  // namespace

template <class Space>
typename Space::PoseVector OdometryTrack<Space>::calibrated_twist(const BodyVelocity& velocity) const {
  typename Space::PoseVector twist = Space::twist(velocity);
  twist.template head<Space::kPointDim>() *= std::exp(calibration_(kLogLinearScale));
  twist.template tail<Space::kTurnDim>() *= std::exp(calibration_(kLogAngularScale));
  return twist;
}

template <class Space>
std::size_t OdometryTrack<Space>::index_at(TimeNs stamp) const {
  const auto after = std::upper_bound(velocities_.begin(), velocities_.end(), stamp,
                                      [](TimeNs time, const RecordedVelocity& v) { return time < v.stamp; });
  return after == velocities_.begin() ? 0 : static_cast<std::size_t>(after - velocities_.begin()) - 1;
}

template <class Space>
void OdometryTrack<Space>::append(const RecordedVelocity& held, double since_stamp, double dt,
                                  Increment<Space>* increment) const {
  using PoseMatrix = typename Space::PoseMatrix;
  using PoseVector = typename Space::PoseVector;
  // The noise is that of what was measured; its metres grow with the scale.
  const auto measured =
      held_motion_step<Space>(held.velocity, held.hold_time - since_stamp, dt, held.velocity, noise_);
  const double moved = std::clamp(held.hold_time - since_stamp, 0.0, dt);
  const PoseVector twist = moved * calibrated_twist(held.velocity);
  const typename Space::Pose step = Space::Pose::exp(twist);
  const PoseMatrix end_from_start = step.inverse().adjoint();
  PoseVector metres = PoseVector::Ones();
  metres.template head<Space::kPointDim>() *= std::exp(calibration_(kLogLinearScale));

  PoseMatrix noise = metres.asDiagonal() * measured.covariance * metres.asDiagonal();
  noise.diagonal().array() += kLeastDensity * dt;
  increment->covariance = end_from_start * increment->covariance * end_from_start.transpose() + noise;

  const PoseMatrix end_from_twist = right_jacobian<Space>(twist);
  increment->by_calibration = end_from_start * increment->by_calibration;
  increment->by_calibration.col(kLogLinearScale) +=
      end_from_twist.template leftCols<Space::kPointDim>() * twist.template head<Space::kPointDim>();
  increment->by_calibration.col(kLogAngularScale) +=
      end_from_twist.template rightCols<Space::kTurnDim>() * twist.template tail<Space::kTurnDim>();
  increment->delta = increment->delta * step;
}

template <class Space>
Increment<Space> OdometryTrack<Space>::between(TimeNs from, TimeNs to) const {
  Increment<Space> increment;
  if (velocities_.empty()) {
    increment.covariance.diagonal().array() += kLeastDensity * to_seconds(to - from);
    return increment;
  }
  const TimeNs delay = to_nanoseconds(calibration_(kDelay));
  const TimeNs end = to - delay;
  TimeNs now = from - delay;
  std::size_t i = index_at(now);
  const auto twist_at = [this](const RecordedVelocity& v, TimeNs stamp) -> typename Space::PoseVector {
    const double since = to_seconds(stamp - v.stamp);
    return since >= 0.0 && since < v.hold_time ? calibrated_twist(v.velocity) : Space::PoseVector::Zero();
  };
  const typename Space::PoseVector first_twist = twist_at(velocities_[i], now);
  while (now < end) {
    const RecordedVelocity& held = velocities_[i];
    const bool is_last = i + 1 == velocities_.size();
    const bool too_early = now < held.stamp;  // nothing was measured yet
    const TimeNs next =
        too_early ? std::min(held.stamp, end) : (is_last ? end : std::min(velocities_[i + 1].stamp, end));
    const double dt = to_seconds(next - now);
    append(too_early ? RecordedVelocity{} : held, too_early ? 0.0 : to_seconds(now - held.stamp), dt,
           &increment);
    if (!too_early && !is_last && next == velocities_[i + 1].stamp) ++i;
    now = next;
  }
  // A later delay takes in more at the start and less at the end.
  increment.by_calibration.col(kDelay) =
      increment.delta.inverse().adjoint() * first_twist - twist_at(velocities_[index_at(end)], end);
  return increment;
}

template class OdometryTrack<Planar>;
template class OdometryTrack<Spatial>;

}  // namespace kinect_ekf_slam
