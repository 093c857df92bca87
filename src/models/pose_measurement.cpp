#include "kinect_ekf_slam/models/pose_measurement.h"

#include <cmath>
#include <limits>

namespace kinect_ekf_slam {

template <class Space>
RangeMeasurement<Space>::RangeMeasurement(const BeaconRange& measured, double beacon_height)
    : receiver_in_base_(Space::from_3d(measured.receiver_in_base)),
      range_(measured.range),
      variance_(measured.variance) {
  if constexpr (Space::kPointDim < 3) height_ = beacon_height - measured.receiver_in_base.z();
}

template <class Space>
double RangeMeasurement<Space>::expected_range(const Pose& map_from_base, const Point& beacon_in_map) const {
  return std::hypot((beacon_in_map - map_from_base * receiver_in_base_).norm(), height_);
}

/// Equations (11.1) to (11.3).
template <class Space>
std::optional<ExpectedMeasurement<Space>> RangeMeasurement<Space>::expect(const Pose& map_from_base,
                                                                          const Point& beacon_in_map) const {
  const Point to_beacon = beacon_in_map - map_from_base * receiver_in_base_;
  const double range = std::hypot(to_beacon.norm(), height_);
  if (!(range > std::numeric_limits<double>::epsilon())) return std::nullopt;
  const Point direction = to_beacon / range;  // a unit vector, but for the height
  const typename Space::PointByPose to_beacon_by_pose =
      map_from_base.rotation() * Space::point_by_pose(receiver_in_base_);

  ExpectedMeasurement<Space> expected;
  expected.innovation.setConstant(1, range_ - range);
  expected.by_pose = direction.transpose() * to_beacon_by_pose;
  expected.by_point = direction.transpose();
  // The root of (I - u u^T) / range: what of the direction the height does not take.
  const typename Space::PointMatrix across =
      (Space::PointMatrix::Identity() -
       direction * direction.transpose() / (1.0 + std::abs(height_) / range)) /
      std::sqrt(range);
  expected.bend = {across * to_beacon_by_pose, across};
  return expected;
}

template <class Space>
PositionMeasurement<Space>::PositionMeasurement(const GlobalPosition& measured)
    : has_attitude_(measured.map_from_base.has_value()),
      antenna_in_base_(Space::from_3d(measured.antenna_in_base)) {
  Eigen::Isometry3d map_from_base = Eigen::Isometry3d::Identity();
  map_from_base.translation() = measured.position_in_map;
  if (has_attitude_) map_from_base.linear() = measured.map_from_base->toRotationMatrix();
  measured_ = Space::pose_from_3d(map_from_base);

  const int rows = has_attitude_ ? Space::kPoseDim : Space::kPointDim;
  noise_.resize(rows, rows);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < rows; ++j) {
      noise_(i, j) = measured.covariance(Space::kPoseAxes[i], Space::kPoseAxes[j]);
    }
  }
  if constexpr (Space::kTurnDim > 1) {  // in the plane a turn has no axes to turn
    if (has_attitude_) {
      Eigen::MatrixXd base_from_map = Eigen::MatrixXd::Identity(rows, rows);
      base_from_map.bottomRightCorner<Space::kTurnDim, Space::kTurnDim>() =
          map_from_base.linear().transpose();
      noise_ = base_from_map * noise_ * base_from_map.transpose();
    }
  }
}

/// Equations (11.4) and (11.5).
template <class Space>
std::optional<ExpectedMeasurement<Space>> PositionMeasurement<Space>::expect(const Pose& map_from_base,
                                                                             const Point& /*point*/) const {
  constexpr int kPointDim = Space::kPointDim;
  const Eigen::Index rows = noise_.rows();
  ExpectedMeasurement<Space> expected;
  expected.innovation.resize(rows);
  expected.by_pose.setZero(rows, Space::kPoseDim);
  expected.by_point.setZero(rows, kPointDim);
  expected.innovation.template head<kPointDim>() = measured_.translation() - map_from_base * antenna_in_base_;
  expected.by_pose.template topRows<kPointDim>() =
      -map_from_base.rotation() * Space::point_by_pose(antenna_in_base_);
  if (has_attitude_) {
    expected.innovation.template tail<Space::kTurnDim>() =
        (map_from_base.inverse() * measured_).log().template tail<Space::kTurnDim>();
    expected.by_pose.template bottomRightCorner<Space::kTurnDim, Space::kTurnDim>().setIdentity();
  }
  return expected;
}

template class RangeMeasurement<Planar>;
template class RangeMeasurement<Spatial>;
template class PositionMeasurement<Planar>;
template class PositionMeasurement<Spatial>;

}  // namespace kinect_ekf_slam
