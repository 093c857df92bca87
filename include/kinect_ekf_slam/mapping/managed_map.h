#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/mapping/life_cycle.h"

namespace kinect_ekf_slam {

/// A Kalman filter whose map is kept: it believes in a landmark only when there is reason to.
template <class Space>
class ManagedMap : public SlamEstimator<Space> {
 public:
  using Observations = std::vector<Observation<Space>>;

  ManagedMap(std::unique_ptr<KalmanSlam<Space>> filter, const LifeCycleOptions& options)
      : filter_(std::move(filter)), life_cycle_(options) {}
  ManagedMap(const ManagedMap& other)
      : SlamEstimator<Space>(other),
        filter_(other.filter_->clone_filter()),
        life_cycle_(other.life_cycle_),
        map_fixed_(other.map_fixed_) {}

  void predict(const MotionStep<Space>& step) override { filter_->predict(step); }
  UpdateReport observe(TimeNs stamp, const Observations& observations) override;
  LocateReport locate(const PoseMeasurement<Space>& measurement, int landmark_id, double gate) override {
    return filter_->locate(measurement, landmark_id, gate);
  }
  void add_landmark(int id, const typename Space::Point& position_in_map,
                    const typename Space::PointMatrix& covariance) override {
    filter_->add_landmark(id, position_in_map, covariance);
  }
  void loosen(const typename Space::PoseMatrix& covariance) override { filter_->loosen(covariance); }

  // The two halves of observe(), as KalmanSlam has them.
  typename KalmanSlam<Space>::Expectation expect(const Observations& observations) {
    return filter_->expect(observations);
  }
  UpdateReport apply(TimeNs stamp, const Observations& observations, std::vector<Assignment> assignments);

  /// Keeps the robot's position in the state, with its correlations, under an id that no landmark has.
  void keep_position(TimeNs stamp, int id);

  PoseEstimate<Space> pose() const override { return filter_->pose(); }
  std::vector<LandmarkEstimate<Space>> landmarks() const override { return filter_->landmarks(); }
  /// Without what is provisional.
  SlamState<Space> snapshot() const override;
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override { filter_->set_pose(pose); }
  void set_map_fixed(bool fixed) override;
  std::unique_ptr<SlamEstimator<Space>> clone() const override { return std::make_unique<ManagedMap>(*this); }

  bool map_fixed() const { return map_fixed_; }

 private:
  void keep(TimeNs stamp, const Observations& observations, UpdateReport* report);

  std::unique_ptr<KalmanSlam<Space>> filter_;
  LifeCycle<Space> life_cycle_;
  bool map_fixed_ = false;
};

}  // namespace kinect_ekf_slam
