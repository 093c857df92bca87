#include "kinect_ekf_slam/estimators/invariant_ekf.h"

namespace kinect_ekf_slam {

/// x = Exp(xi) x, and P = T(x_new) T(x_old)^-1 (P - U U^T) (...)^T: equations (7.3) and (7.4), at once.
template <class Space>
void InvariantEkf<Space>::correct(const Eigen::Ref<const Eigen::MatrixXd>& U,
                                  const Eigen::Ref<const Eigen::VectorXd>& error) {
  constexpr int kTurnDim = Space::kTurnDim;
  using Pose = typename Space::Pose;
  using TurnMatrix = Eigen::Matrix<double, kTurnDim, kTurnDim>;
  const Eigen::Matrix<double, kTurnDim, 1> turn = error.template segment<kTurnDim>(kPointDim);
  Eigen::Map<Eigen::MatrixXd> left = left_.matrix(state_.size(), U.cols() + Eigen::Index{2} * kTurnDim);
  Eigen::Map<Eigen::MatrixXd> right = right_.matrix(left.rows(), left.cols());

  // One rotation for all points, and the displacement of each on the way: Exp of (xi, turn).
  auto by_turn = left.middleCols<kTurnDim>(U.cols());  // B: T(x_new) T(x_old)^-1 - I
  by_turn.setZero();
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

  // With C the columns of P - U U^T by the turn and C_t its rows by the turn:
  // P - U U^T + B C^T + C B^T + B C_t B^T = P - U U^T + B A^T + A B^T, A = C + B C_t / 2.
  auto A = left.rightCols<kTurnDim>();
  A = -U.lazyProduct(U.template middleRows<kTurnDim>(kPointDim).transpose());
  state_.covariance().add_weighted_columns(kPointDim, TurnMatrix(TurnMatrix::Identity()), A);
  const TurnMatrix C_t = A.template middleRows<kTurnDim>(kPointDim);
  A.noalias() += 0.5 * by_turn * C_t;
  left.leftCols(U.cols()) = -U;
  right << U, A, by_turn;
  state_.covariance().add_product(1.0, left, right);
}

template <class Space>
void InvariantEkf<Space>::retract(const Eigen::Ref<const Eigen::VectorXd>& error) {
  correct(Eigen::MatrixXd(state_.size(), 0), error);
}

template class InvariantEkf<Planar>;
template class InvariantEkf<Spatial>;

}  // namespace kinect_ekf_slam
