/// The report's worked figures for Gaussians and the linear Kalman filter, and what holds besides.
#include "kinect_ekf_slam/estimators/gaussian.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;

Gaussian<1> gaussian(double mean, double variance) {
  Gaussian<1> result;
  result.mean << mean;
  result.covariance << variance;
  return result;
}

TEST(LinearKalmanFilter, PredictsTheReportsWorkedExampleOnALine) {
  const Gaussian<1> step = gaussian(1.0, 4.0 * 4.0);
  const Gaussian<1> moved = predicted<1>(gaussian(2.0, 2.0 * 2.0), Eigen::Matrix<double, 1, 1>::Identity(),
                                         step.mean, step.covariance);
  EXPECT_DOUBLE_EQ(moved.mean(0), 3.0);
  EXPECT_DOUBLE_EQ(moved.covariance(0), 20.0);
}

/// The report's prior in the plane, mean (3, 2) and covariance [4 1; 1 5], as the sum of a belief and a move.
TEST(LinearKalmanFilter, PredictsTheReportsWorkedExampleInThePlane) {
  Gaussian<2> belief;
  belief.mean << 2.0, 2.0;
  belief.covariance << 1.0, 1.0, 1.0, 2.0;
  const Gaussian<2> moved =
      predicted<2>(belief, Eigen::Matrix2d::Identity(), {1.0, 0.0}, 3.0 * Eigen::Matrix2d::Identity());
  EXPECT_TRUE(MatrixNear(moved.mean, Eigen::Vector2d(3.0, 2.0), 0.0));
  EXPECT_TRUE(MatrixNear(moved.covariance, (Eigen::Matrix2d() << 4.0, 1.0, 1.0, 5.0).finished(), 0.0));
}

TEST(LinearKalmanFilter, CorrectsByTheProductOfTheGaussians) {
  Gaussian<1> x = gaussian(3.0, 20.0);
  const Gaussian<1>::Matrix one = Gaussian<1>::Matrix::Identity();
  const auto fit = correct<1, 1>(Gaussian<1>::Vector(7.0) - x.mean, one, 5.0 * one, &x);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(x.covariance(0), 1.0 / (1.0 / 20.0 + 1.0 / 5.0), 1e-12);
  EXPECT_NEAR(x.mean(0), x.covariance(0) * (3.0 / 20.0 + 7.0 / 5.0), 1e-12);
  EXPECT_NEAR(fit->squared_distance, 16.0 / 25.0, 1e-12);
  EXPECT_NEAR(fit->log_likelihood, -0.5 * 16.0 / 25.0 - 0.5 * std::log(2.0 * kPi * 25.0), 1e-12);
}

TEST(LinearKalmanFilter, IsTheTextbooksWithFullMatrices) {
  Gaussian<3> x;
  x.mean << 1.0, -2.0, 0.5;
  x.covariance << 2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 0.5;
  const Gaussian<3> prior = x;
  const Eigen::Matrix<double, 2, 3> H =
      (Eigen::Matrix<double, 2, 3>() << 1.0, 0.5, 0.0, -1.0, 0.0, 2.0).finished();
  const Eigen::Matrix2d R = (Eigen::Matrix2d() << 0.4, 0.1, 0.1, 0.3).finished();
  const Eigen::Vector2d z(0.3, 1.1);
  ASSERT_TRUE((correct<3, 2>(z - H * x.mean, H, R, &x)));
  const Eigen::MatrixXd K =
      prior.covariance * H.transpose() * (H * prior.covariance * H.transpose() + R).inverse();
  EXPECT_TRUE(MatrixNear(x.mean, prior.mean + K * (z - H * prior.mean), 1e-12));
  EXPECT_TRUE(MatrixNear(x.covariance, (Eigen::Matrix3d::Identity() - K * H) * prior.covariance, 1e-12));
  EXPECT_TRUE(IsCovariance(x.covariance));
}

TEST(LinearKalmanFilter, LeavesTheStateAloneWhenTheInnovationIsSingular) {
  Gaussian<1> x = gaussian(3.0, 0.0);
  const Gaussian<1>::Matrix one = Gaussian<1>::Matrix::Identity();
  EXPECT_FALSE((correct<1, 1>(Gaussian<1>::Vector(1.0), one, 0.0 * one, &x)));
  EXPECT_EQ(x.mean(0), 3.0);
}

/// The report, equation 30: Z = w1 X + w2 Y has the mean w1 u1 + w2 u2 and the variance w1^2 s1 + w2^2 s2.
TEST(WeightedSum, HasTheReportsMeanAndVariance) {
  const Gaussian<1> sum = weighted_sum(2.0, gaussian(1.0, 4.0), -3.0, gaussian(0.5, 9.0));
  EXPECT_DOUBLE_EQ(sum.mean(0), 2.0 * 1.0 - 3.0 * 0.5);
  EXPECT_DOUBLE_EQ(sum.covariance(0), 4.0 * 4.0 + 9.0 * 9.0);

  RandomStream random(1, 0);
  const int draws = 200000;
  double mean = 0.0;
  double square = 0.0;
  for (int i = 0; i < draws; ++i) {
    const double x = 1.0 + 2.0 * random.normal();
    const double y = 0.5 + 3.0 * random.normal();
    mean += (2.0 * x - 3.0 * y) / draws;
    square += (2.0 * x - 3.0 * y) * (2.0 * x - 3.0 * y) / draws;
  }
  EXPECT_NEAR(sum.mean(0), mean, 0.1);
  EXPECT_NEAR(sum.covariance(0), square - mean * mean, 1.0);
}

/// Not to be confused with the weighted sum: a mixture is one or the other.
TEST(Mixture, HasTheSpreadWithinItsPartsAndBetweenThem) {
  const Gaussian<1> mixture = moments_of_mixture<1>({0.25, 0.75}, {gaussian(0.0, 1.0), gaussian(4.0, 2.0)});
  EXPECT_DOUBLE_EQ(mixture.mean(0), 3.0);
  EXPECT_DOUBLE_EQ(mixture.covariance(0), 0.25 * (1.0 + 9.0) + 0.75 * (2.0 + 1.0));
}

}  // namespace
}  // namespace kinect_ekf_slam
