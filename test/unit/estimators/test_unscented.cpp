#include "kinect_ekf_slam/estimators/unscented.h"

#include <gtest/gtest.h>

#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

const Eigen::Matrix3d kCovariance =
    (Eigen::Matrix3d() << 0.5, 0.1, -0.05, 0.1, 0.3, 0.02, -0.05, 0.02, 0.1).finished();

TEST(UnscentedTransform, IsExactForALinearFunction) {
  const Eigen::MatrixXd A = (Eigen::MatrixXd(2, 3) << 1.0, 2.0, -0.5, 0.0, -1.0, 3.0).finished();
  const Eigen::Vector2d b(4.0, -1.0);
  const auto result = unscented_transform(kCovariance.llt().matrixL(), {}, [&](const Eigen::VectorXd& error) {
    return Eigen::VectorXd(A * error + b);
  });
  EXPECT_TRUE(MatrixNear(result.mean, b, 1e-12));
  EXPECT_TRUE(MatrixNear(result.covariance, A * kCovariance * A.transpose(), 1e-12));
  EXPECT_TRUE(MatrixNear(result.slope, A, 1e-12));
}

/// From polar to cartesian with a wide bearing: the Jacobian misses how far the mean moves towards the
/// origin.
TEST(UnscentedTransform, SeesWhatAJacobianDoesNot) {
  const Eigen::Vector2d sigma(0.02, radians(15.0));
  const auto place = [](const Eigen::VectorXd& error) {
    return Eigen::VectorXd(
        Eigen::Vector2d((1.0 + error(0)) * std::cos(error(1)), (1.0 + error(0)) * std::sin(error(1))));
  };
  const auto result = unscented_transform(Eigen::MatrixXd(sigma.asDiagonal()), {}, place);

  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();
  const int samples = 200000;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector2d value =
        place(Eigen::Vector2d(sigma(0) * normal(random), sigma(1) * normal(random)));
    mean += value / samples;
    second_moment += value * value.transpose() / samples;
  }
  EXPECT_TRUE(MatrixNear(result.mean, mean, 1e-3));
  EXPECT_LT(result.mean(0), 0.98) << "a Jacobian says 1";
  EXPECT_TRUE(MatrixNear(result.covariance, second_moment - mean * mean.transpose(), 5e-3));
}

/// A heading that is uncertain by 25 degrees on both sides of +-180: the mean stays there.
TEST(Ukf, AveragesHeadingsOnTheCircle) {
  PoseEstimate<Planar> start;
  start.map_from_base = Se2(0.0, 0.0, kPi);
  start.covariance.diagonal() << 0.01, 0.01, std::pow(radians(25.0), 2);
  const auto ukf = make_estimator<Planar>(testing::textbook(EstimatorOptions::Type::kUkf),
                                          testing::known_identities(), start);
  ukf->predict(testing::motion<Planar>(Se2(1.0, 0.0, 0.0), 0.01));
  const PoseEstimate<Planar> moved = ukf->pose();
  EXPECT_NEAR(std::abs(moved.map_from_base.angle()), kPi, 1e-9);
  // E[cos] of a Gaussian angle is exp(-sigma^2 / 2): the mean of the banana lies inside the arc.
  EXPECT_NEAR(moved.map_from_base.translation().x(), -std::exp(-0.5 * start.covariance(2, 2)), 5e-3);
  EXPECT_NEAR(moved.covariance(2, 2), start.covariance(2, 2) + 1e-4, 1e-6);
}

}  // namespace
}  // namespace kinect_ekf_slam
