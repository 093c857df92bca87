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
  using typename Base::Point;
  using typename Base::PointMatrix;
  using typename Base::PredictedMeasurement;
  void predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) override;

  bool predict_measurement(const PoseMeasurement<Space>& measurement, int landmark,
                           PredictedMeasurement* predicted) override;

  std::vector<Jacobian> H_;  ///< of the last joint measurement, one a match
  /// Of the last measurement by locate(): the rows of H by the pose's error and by the landmark's.
  struct Located {
    typename ExpectedMeasurement<Space>::template Rows<kPoseDim> by_pose;
    typename ExpectedMeasurement<Space>::template Rows<kPointDim> by_landmark;
    int landmark = -1;  ///< its index, -1: the pose alone was measured
  };
  Located located_;
};

}  // namespace kinect_ekf_slam
