#include "test/support/matchers.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam::testing {

::testing::AssertionResult MatrixNear(const Eigen::Ref<const Eigen::MatrixXd>& left,
                                      const Eigen::Ref<const Eigen::MatrixXd>& right, double tolerance) {
  if (left.rows() == right.rows() && left.cols() == right.cols()) {
    const double difference = left.size() == 0 ? 0.0 : (left - right).cwiseAbs().maxCoeff();
    if (difference <= tolerance) return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "\n" << left << "\nis not within " << tolerance << " of\n" << right;
}

::testing::AssertionResult AngleNear(double left, double right, double tolerance) {
  if (std::abs(wrap_angle(left - right)) <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << left << " and " << right << " differ by more than " << tolerance;
}

::testing::AssertionResult PoseNear(const Se2& left, const Se2& right, double tolerance) {
  const auto position = MatrixNear(left.translation(), right.translation(), tolerance);
  return position ? AngleNear(left.angle(), right.angle(), tolerance) : position;
}

::testing::AssertionResult PoseNear(const Se3& left, const Se3& right, double tolerance) {
  const auto position = MatrixNear(left.translation(), right.translation(), tolerance);
  return position ? MatrixNear(left.rotation(), right.rotation(), tolerance) : position;
}

::testing::AssertionResult IsCovariance(const Eigen::Ref<const Eigen::MatrixXd>& matrix, double tolerance) {
  if (matrix != matrix.transpose()) return ::testing::AssertionFailure() << "not symmetric:\n" << matrix;
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues();
  if (eigenvalues.minCoeff() >= -tolerance * eigenvalues.maxCoeff()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "smallest eigenvalue " << eigenvalues.minCoeff();
}

Eigen::MatrixXd numerical_jacobian(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
                                   const Eigen::VectorXd& x, double step) {
  const Eigen::VectorXd at_x = function(x);
  Eigen::MatrixXd jacobian(at_x.size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd up = x;
    Eigen::VectorXd down = x;
    up(i) += step;
    down(i) -= step;
    jacobian.col(i) = (function(up) - function(down)) / (2.0 * step);
  }
  return jacobian;
}

}  // namespace kinect_ekf_slam::testing
