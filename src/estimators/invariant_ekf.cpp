#include "kinect_ekf_slam/estimators/invariant_ekf.h"

namespace kinect_ekf_slam {

/// x = Exp(xi) x, and P = T(x_new) T(x_old)^-1 P (...)^T: equations (7.3) and (7.4).
template <class Space>
void InvariantEkf<Space>::retract(const Eigen::Ref<const Eigen::VectorXd>& error) {
  constexpr int kTurnDim = Space::kTurnDim;
  using Pose = typename Space::Pose;
  const Eigen::Matrix<double, kTurnDim, 1> turn = error.template segment<kTurnDim>(kPointDim);

  // One rotation for all points, and the displacement of each on the way: Exp of (xi, turn).
  Eigen::MatrixXd by_turn = Eigen::MatrixXd::Zero(state_.size(), kTurnDim);  // B: T(x_new) T(x_old)^-1 - I
  const auto moved = [&](const Point& point, int row) -> Pose {
    typename Space::PoseVector xi;
    xi << error.template segment<kPointDim>(row) - Space::by_turn(point) * turn, turn;
    Pose rigid = Pose::exp(xi);
    by_turn.template middleRows<kPointDim>(row) = Space::by_turn(rigid * point - point);
    return rigid;
  };
  const Pose pose = state_.map_from_base();
  state_.set_map_from_base(moved(pose.translation(), 0) * pose);
  for (int i = 0; state_.row(i) < error.size(); ++i) {
    const Point point = state_.landmark(i);
    state_.set_landmark(i, moved(point, state_.row(i)) * point);
  }

  // With C the columns of P by the turn and C_t its rows by the turn:
  // P + B C^T + C B^T + B C_t B^T = P + B A^T + A B^T, A = C + B C_t / 2.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(state_.size(), kTurnDim);
  state_.add_weighted_columns(kPointDim, Eigen::Matrix<double, kTurnDim, kTurnDim>::Identity(), A);
  A += 0.5 * by_turn * A.template middleRows<kTurnDim>(kPointDim).eval();
  auto P = state_.lower().template triangularView<Eigen::Lower>();
  P += by_turn * A.transpose();
  P += A * by_turn.transpose();
}

template class InvariantEkf<Planar>;
template class InvariantEkf<Spatial>;

}  // namespace kinect_ekf_slam
