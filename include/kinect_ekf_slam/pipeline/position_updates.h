#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>

#include "kinect_ekf_slam/estimators/slam_estimator.h"
#include "kinect_ekf_slam/pipeline/global_alignment.h"
#include "kinect_ekf_slam/pipeline/position_options.h"
#include "kinect_ekf_slam/pipeline/position_watch.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// Brings positions and ranges to beacons into an estimate: checks them, finds where the map lies in the
/// frame of the global ones, and says what became of each (docs/theory.md, section 11).
template <class Space>
class PositionUpdates {
 public:
  using Estimator = SlamEstimator<Space>;
  explicit PositionUpdates(const PositionOptions& options);

  /// The beacons of the list that are not in the map yet.
  void add_beacons(Estimator* estimator) const;
  /// What the frame says of the robot's place, at a time that the estimate has reached. `late`: it is past
  /// it.
  void take(const SensorFrame& frame, bool late, Estimator* estimator, SlamResult* result);

  /// The estimate contradicts what tells the position.
  bool is_lost() const { return watch_.is_lost(); }
  const std::optional<Eigen::Isometry3d>& map_from_global() const { return map_from_global_; }
  /// The robot was put somewhere.
  void pose_was_set() { watch_.reset(); }
  /// The map is another one: where it lies is not known.
  void map_was_replaced();
  double beacon_height(int beacon) const;

 private:
  /// Invalid, late or withheld; else used, until it is tried.
  PositionVerdict check(const GlobalPosition& position, bool late, TimeNs stamp) const;
  PositionOutcome take_position(const GlobalPosition& position, TimeNs stamp, Estimator* estimator);
  PositionOutcome align(const GlobalPosition& global_position, TimeNs stamp, Estimator* estimator);
  PositionOutcome take_range(const BeaconRange& range, TimeNs stamp, Estimator* estimator);
  PositionOutcome locate(const PoseMeasurement<Space>& measurement, int beacon, TimeNs stamp,
                         Estimator* estimator);
  /// One outside the gate: an outlier, or the estimate is wrong.
  void note_contradiction(int beacon, TimeNs stamp, const Eigen::VectorXd& innovation,
                          const Eigen::MatrixXd& noise, Estimator* estimator);
  /// The estimate was wrong by so much: it does not know where the robot is any better.
  void distrust(double distance, Estimator* estimator) const;
  /// With errors that say again what the last ones said.
  GlobalPosition with_correlation(GlobalPosition position, TimeNs stamp);

  PositionOptions options_;
  std::map<int, Beacon> beacons_;
  std::map<Eigen::Index, double> gates_;  ///< by the numbers measured
  GlobalAlignment<Space> alignment_;
  std::optional<Eigen::Isometry3d> map_from_global_;
  PositionWatch watch_;
  std::optional<TimeNs> first_;          ///< of the run
  std::optional<TimeNs> last_position_;  ///< that was used
  typename Space::Point last_sure_;      ///< m, in the map: where the robot was when one was accepted
};

}  // namespace kinect_ekf_slam
