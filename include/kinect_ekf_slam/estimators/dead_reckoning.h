#pragma once

#include <memory>
#include <vector>

#include "kinect_ekf_slam/estimators/landmark_ids.h"
#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

/// The open loop: landmarks are plotted where they are seen, the last sighting counts, nothing is corrected.
template <class Space>
class DeadReckoning : public SlamEstimator<Space> {
 public:
  DeadReckoning(const EstimatorOptions& options, std::shared_ptr<const Associator<Space>> associator,
                const PoseEstimate<Space>& initial)
      : options_(options),
        associator_(std::move(associator)),
        pose_(initial),
        ids_(associator_->knows_identities()) {}

  void predict(const MotionStep<Space>& step) override;
  UpdateReport observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) override;
  PoseEstimate<Space> pose() const override { return pose_; }
  std::vector<LandmarkEstimate<Space>> landmarks() const override { return landmarks_; }
  SlamState<Space> snapshot() const override;
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override { pose_ = pose; }
  void set_map_fixed(bool fixed) override { map_fixed_ = fixed; }
  std::unique_ptr<SlamEstimator<Space>> clone() const override {
    return std::make_unique<DeadReckoning>(*this);
  }

 private:
  class Prediction;

  EstimatorOptions options_;
  std::shared_ptr<const Associator<Space>> associator_;
  PoseEstimate<Space> pose_;
  std::vector<LandmarkEstimate<Space>> landmarks_;
  bool map_fixed_ = false;
  LandmarkIds ids_;
};

}  // namespace kinect_ekf_slam
