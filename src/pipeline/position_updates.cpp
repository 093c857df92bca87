#include "kinect_ekf_slam/pipeline/position_updates.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/models/measurement.h"
#include "kinect_ekf_slam/models/pose_measurement.h"
#include "kinect_ekf_slam/pipeline/usable_position.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kLargestTurn = 0.5;  // rad of doubt at once: beyond it no Kalman filter is at home
constexpr double kShortestWay = 1.0;  // m

GlobalPosition moved(const Eigen::Isometry3d& to_from, const GlobalPosition& position) {
  GlobalPosition result = position;
  result.position_in_map = to_from * position.position_in_map;
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = to_from.linear();
  turn.bottomRightCorner<3, 3>() = to_from.linear();
  result.covariance = turn * position.covariance * turn.transpose();
  if (position.map_from_base) {
    result.map_from_base = Eigen::Quaterniond(to_from.linear()) * *position.map_from_base;
  }
  return result;
}

}  // namespace

template <class Space>
PositionUpdates<Space>::PositionUpdates(const PositionOptions& options)
    : options_(options), watch_(options.lost_after), last_sure_(Space::Point::Zero()) {
  for (const Beacon& beacon : options.beacons) beacons_[beacon.id] = beacon;
  for (const Eigen::Index dof : {1, Space::kPointDim, Space::kPoseDim}) {
    gates_[dof] = chi_square_quantile(options.gate_probability, static_cast<double>(dof));
  }
}

template <class Space>
void PositionUpdates<Space>::add_beacons(Estimator* estimator) const {
  std::set<int> present;
  for (const auto& landmark : estimator->landmarks()) present.insert(landmark.info.id);
  for (const auto& [id, beacon] : beacons_) {
    if (present.count(beacon_landmark_id(id)) > 0) continue;
    estimator->add_landmark(beacon_landmark_id(id), Space::from_3d(beacon.position_in_map),
                            beacon.sigma * beacon.sigma * Space::PointMatrix::Identity());
  }
}

template <class Space>
double PositionUpdates<Space>::beacon_height(int beacon) const {
  const auto listed = beacons_.find(beacon);
  return listed == beacons_.end() ? 0.0 : listed->second.position_in_map.z();
}

template <class Space>
void PositionUpdates<Space>::map_was_replaced() {
  watch_.reset();
  alignment_.clear();
  map_from_global_.reset();
}

template <class Space>
void PositionUpdates<Space>::take(const SensorFrame& frame, bool late, Estimator* estimator,
                                  SlamResult* result) {
  if (!first_) first_ = frame.stamp;
  if (frame.position) {
    const PositionVerdict verdict = check(*frame.position, late, frame.stamp);
    PositionOutcome outcome{verdict};
    if (verdict == PositionVerdict::kUsed) outcome = take_position(*frame.position, frame.stamp, estimator);
    outcome.position_in_map = frame.position->position_in_map;
    result->positions.push_back(outcome);
  }
  if (frame.global_position) {
    PositionOutcome outcome{check(*frame.global_position, late, frame.stamp)};
    if (outcome.verdict == PositionVerdict::kUsed && !map_from_global_) {
      outcome = align(*frame.global_position, frame.stamp, estimator);
    } else if (map_from_global_) {
      const GlobalPosition position = moved(*map_from_global_, *frame.global_position);
      if (outcome.verdict == PositionVerdict::kUsed)
        outcome = take_position(position, frame.stamp, estimator);
      outcome.position_in_map = position.position_in_map;
    }
    result->positions.push_back(outcome);
  }
  for (const BeaconRange& range : frame.ranges) {
    PositionOutcome outcome{PositionVerdict::kLate, range.beacon};
    if (!late) outcome = take_range(range, frame.stamp, estimator);
    result->positions.push_back(outcome);
  }
}

template <class Space>
PositionVerdict PositionUpdates<Space>::check(const GlobalPosition& position, bool late, TimeNs stamp) const {
  if (!is_usable(position)) return PositionVerdict::kInvalid;
  if (late) return PositionVerdict::kLate;
  return options_.is_withheld(to_seconds(stamp - first_.value_or(stamp))) ? PositionVerdict::kWithheld
                                                                          : PositionVerdict::kUsed;
}

template <class Space>
GlobalPosition PositionUpdates<Space>::with_correlation(GlobalPosition position, TimeNs stamp) {
  if (last_position_) {
    position.covariance *=
        correlation_inflation(to_seconds(stamp - *last_position_), options_.correlation_time);
  }
  last_position_ = stamp;
  return position;
}

/// An echo weighs less, but errs by no more than it says: the gate is for the error as told.
template <class Space>
PositionOutcome PositionUpdates<Space>::take_position(const GlobalPosition& position, TimeNs stamp,
                                                      Estimator* estimator) {
  const PositionMeasurement<Space> told(position);
  const PoseEstimate<Space> pose = estimator->pose();
  const auto expected = told.expect(pose.map_from_base);
  const Eigen::MatrixXd noise = told.noise();
  const Eigen::MatrixXd H = expected->by_pose * local_from_error<Space>(pose.map_from_base);
  const auto distance =
      squared_mahalanobis<Eigen::Dynamic>(expected->innovation, H * pose.covariance * H.transpose() + noise);
  const int dof = static_cast<int>(noise.rows());
  if (distance && !(*distance < gates_.at(dof))) {
    note_contradiction(kNoId, stamp, expected->innovation, noise, estimator);
    return {PositionVerdict::kOutsideGate, kNoId, *distance, dof};
  }
  return locate(PositionMeasurement<Space>(with_correlation(position, stamp)), kNoId, stamp, estimator);
}

/// Until it is known where the map lies, positions are taken for that; once it is, the map lies there by
/// definition, and what is not sure of it is how the estimate lies in the map: equation (11.10).
template <class Space>
PositionOutcome PositionUpdates<Space>::align(const GlobalPosition& global_position, TimeNs stamp,
                                              Estimator* estimator) {
  const PoseEstimate<Space> pose = estimator->pose();
  const auto antenna = PositionMeasurement<Space>(global_position).expect(pose.map_from_base);
  const Eigen::Matrix<double, Space::kPointDim, Space::kPoseDim> H =
      antenna->by_pose.template topRows<Space::kPointDim>() * local_from_error<Space>(pose.map_from_base);
  typename GlobalAlignment<Space>::Pair pair;
  pair.antenna_in_map =
      pose.map_from_base * typename Space::Point(Space::from_3d(global_position.antenna_in_base));
  pair.antenna_covariance = H * pose.covariance * H.transpose();
  pair.position = Space::from_3d(global_position.position_in_map);
  pair.position_covariance = Space::from_3d(
      Eigen::Matrix3d(with_correlation(global_position, stamp).covariance.template topLeftCorner<3, 3>()));
  alignment_.add(pair);
  const auto solution = alignment_.solve();
  if (solution && solution->heading_sigma < radians(options_.align_heading_sigma_deg)) {
    map_from_global_ = solution->map_from_global;
    estimator->loosen(solution->covariance);
    last_sure_ = pose.map_from_base.translation();
    alignment_.clear();
  }
  return {PositionVerdict::kAligning};
}

template <class Space>
PositionOutcome PositionUpdates<Space>::take_range(const BeaconRange& range, TimeNs stamp,
                                                   Estimator* estimator) {
  PositionOutcome outcome{PositionVerdict::kInvalid, range.beacon};
  if (!is_usable(range)) return outcome;
  if (beacons_.count(range.beacon) == 0) {
    outcome.verdict = PositionVerdict::kUnknownBeacon;
    return outcome;
  }
  return locate(RangeMeasurement<Space>(range, beacon_height(range.beacon)), range.beacon, stamp, estimator);
}

template <class Space>
PositionOutcome PositionUpdates<Space>::locate(const PoseMeasurement<Space>& measurement, int beacon,
                                               TimeNs stamp, Estimator* estimator) {
  const Eigen::MatrixXd noise = measurement.noise();
  const int landmark_id = beacon == kNoId ? kNoId : beacon_landmark_id(beacon);
  const LocateReport report = estimator->locate(measurement, landmark_id, gates_.at(noise.rows()));
  if (report.verdict == PositionVerdict::kUsed) {
    watch_.accepted();
    last_sure_ = estimator->pose().map_from_base.translation();
  } else if (report.verdict == PositionVerdict::kOutsideGate) {
    note_contradiction(beacon, stamp, report.innovation, noise, estimator);
  }
  return {report.verdict, beacon, report.squared_distance, static_cast<int>(noise.rows())};
}

template <class Space>
void PositionUpdates<Space>::note_contradiction(int beacon, TimeNs stamp, const Eigen::VectorXd& innovation,
                                                const Eigen::MatrixXd& noise, Estimator* estimator) {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // of a range, along one axis
  const Eigen::Index rows = std::min<Eigen::Index>(noise.rows(), Space::kPointDim);
  offset.head(rows) = innovation.head(rows);
  const double sigma = std::sqrt(noise.topLeftCorner(rows, rows).trace());
  if (watch_.refused(beacon, stamp, offset, sigma)) distrust(offset.norm(), estimator);
}

template <class Space>
void PositionUpdates<Space>::distrust(double distance, Estimator* estimator) const {
  const double way = (estimator->pose().map_from_base.translation() - last_sure_).norm();
  const double turn = std::min(distance / std::max(way, kShortestWay), kLargestTurn);
  MotionStep<Space> doubt;
  doubt.covariance.diagonal().setConstant(turn * turn);
  doubt.covariance.diagonal().template head<Space::kPointDim>().setConstant(distance * distance);
  estimator->predict(doubt);
}

template class PositionUpdates<Planar>;
template class PositionUpdates<Spatial>;

}  // namespace kinect_ekf_slam
