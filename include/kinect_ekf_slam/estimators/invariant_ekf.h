#pragma once

#include "kinect_ekf_slam/estimators/ekf.h"

namespace kinect_ekf_slam {

/// The right-invariant EKF on SE_{n+1} (Barrau and Bonnabel, arXiv 1510.06263; Zhang et al., arXiv
/// 1702.06680).
///
/// The error is that of the whole map and robot as one rigid body, moved by Exp(xi) in the map. Its
/// linearisation does not depend on the estimate, so where the map stands and turns, which no sensor tells,
/// never seems to be learnt. Written in the error of the EKF, the filter differs from it in one step alone:
/// how a correction moves the estimate, and its covariance with it (docs/theory.md, section 7).
template <class Space>
class InvariantEkf : public Ekf<Space> {
 public:
  using Ekf<Space>::Ekf;
  std::unique_ptr<KalmanSlam<Space>> clone_filter() const override {
    return std::make_unique<InvariantEkf>(*this);
  }

 protected:
  using typename Ekf<Space>::Point;
  using Ekf<Space>::kPointDim;
  using Ekf<Space>::state_;
  void correct(const Eigen::Ref<const Eigen::MatrixXd>& U,
               const Eigen::Ref<const Eigen::VectorXd>& error) override;
  void retract(const Eigen::Ref<const Eigen::VectorXd>& error) override;

 private:
  Scratch left_, right_;  ///< the factors of what a correction adds to the covariance
};

}  // namespace kinect_ekf_slam
