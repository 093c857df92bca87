#pragma once

#include "kinect_ekf_slam/estimators/kalman_slam.h"
#include "kinect_ekf_slam/estimators/unscented.h"

namespace kinect_ekf_slam {

/// The unscented Kalman filter: sigma points instead of Jacobians (docs/theory.md, section 8).
///
/// They are drawn over the pose and the landmarks observed; the rest of the map follows by its
/// cross-covariance, as in every Kalman filter.
template <class Space>
class Ukf : public KalmanSlam<Space> {
 public:
  using KalmanSlam<Space>::KalmanSlam;
  void predict(const MotionStep<Space>& step) override;
  std::unique_ptr<KalmanSlam<Space>> clone_filter() const override { return std::make_unique<Ukf>(*this); }

 protected:
  using Base = KalmanSlam<Space>;
  using Base::kPointDim;
  using Base::kPoseDim;
  using Base::state_;
  using typename Base::Match;
  using typename Base::Point;
  using typename Base::PredictedMeasurement;
  void predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) override;
  bool predict_measurement(const PoseMeasurement<Space>& measurement, int landmark,
                           PredictedMeasurement* predicted) override;

 private:
  /// Sends the sigma points of the pose and these landmarks through `function`, from (pose, points one after
  /// the other) to a vector.
  template <class Function>
  void transform(const std::vector<int>& landmarks, const Function& function,
                 PredictedMeasurement* predicted) const;
};

}  // namespace kinect_ekf_slam
