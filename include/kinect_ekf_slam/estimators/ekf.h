#pragma once

#include "kinect_ekf_slam/estimators/kalman_slam.h"

namespace kinect_ekf_slam {

/// The extended Kalman filter of the textbook: linear in the error, by Jacobians (docs/theory.md, section 4).
template <class Space>
class Ekf : public KalmanSlam<Space> {
 public:
  using KalmanSlam<Space>::KalmanSlam;
  std::unique_ptr<KalmanSlam<Space>> clone_filter() const override { return std::make_unique<Ekf>(*this); }

 protected:
  using Base = KalmanSlam<Space>;
  using Base::kPointDim;
  using Base::kPoseDim;
  using Base::state_;
  using typename Base::Jacobian;
  using typename Base::Match;
  using typename Base::PredictedMeasurement;
  void predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) override;

  std::vector<Jacobian> H_;  ///< of the last joint measurement, one a match
};

}  // namespace kinect_ekf_slam
