#include "kinect_ekf_slam/fusion/combination.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;

template <int Dim>
Gaussian<Dim> random_gaussian(RandomStream* random) {
  const auto normal = [&] { return random->normal(); };
  const Eigen::Matrix<double, Dim, Dim> A = Eigen::Matrix<double, Dim, Dim>::NullaryExpr(normal);
  return {Eigen::Matrix<double, Dim, 1>::NullaryExpr(normal),
          A * A.transpose() + 0.1 * Eigen::Matrix<double, Dim, Dim>::Identity()};
}

TEST(Combination, OfTwoNumbersIsTheSourcesFormula) {
  Gaussian<1> buoys;
  buoys.mean << 2.0;
  buoys.covariance << 4.0;
  Gaussian<1> camera;
  camera.mean << 5.0;
  camera.covariance << 1.0;
  const Combination<1> result = combine<1>(buoys, camera, 0.99);
  ASSERT_TRUE(result.fused);
  EXPECT_NEAR(result.fused->mean(0), 4.0 / 5.0 * 5.0 + 1.0 / 5.0 * 2.0, 1e-12);
  EXPECT_NEAR(result.fused->covariance(0), 4.0 * 1.0 / 5.0, 1e-12);
  EXPECT_NEAR(result.squared_distance, 9.0 / 5.0, 1e-12);
}

TEST(Combination, AddsInformationMatrices) {
  RandomStream random(1, 0);
  for (int run = 0; run < 20; ++run) {
    const Gaussian<3> b = random_gaussian<3>(&random);
    const Gaussian<3> c = random_gaussian<3>(&random);
    const Combination<3> result = combine<3>(b, c, 1.0 - 1e-12);
    ASSERT_TRUE(result.fused);
    const Eigen::Matrix3d P = (b.covariance.inverse() + c.covariance.inverse()).inverse();
    EXPECT_TRUE(MatrixNear(result.fused->covariance, P, 1e-9));
    EXPECT_TRUE(MatrixNear(result.fused->mean,
                           P * (b.covariance.inverse() * b.mean + c.covariance.inverse() * c.mean), 1e-9));
  }
}

TEST(Combination, TellsBothEstimatesThatDisagreeAndFusesNothing) {
  Gaussian<2> gps;
  gps.mean << 20.0, 0.0;
  gps.covariance.setIdentity();
  Gaussian<2> path;
  path.covariance.setIdentity();
  const Combination<2> result = combine<2>(gps, path, 0.999);
  EXPECT_FALSE(result.fused);
  EXPECT_NEAR(result.squared_distance, 400.0 / 2.0, 1e-9);
  EXPECT_TRUE(MatrixNear(result.first.mean, gps.mean, 0.0));
  EXPECT_TRUE(MatrixNear(result.second.mean, path.mean, 0.0));
}

/// The overlap test refuses as many true pairs as it says: 2 % of 20000, give or take four sigmas of that
/// count.
TEST(Combination, RefusesAsManyAsItSays) {
  RandomStream random(2, 0);
  int refused = 0;
  const int runs = 20000;
  for (int run = 0; run < runs; ++run) {
    Gaussian<2> b;
    b.covariance << 1.0, 0.5, 0.5, 2.0;
    Gaussian<2> c;
    c.covariance << 0.3, -0.1, -0.1, 0.2;
    b.mean = b.covariance.llt().matrixL() * Eigen::Vector2d(random.normal(), random.normal());
    c.mean = c.covariance.llt().matrixL() * Eigen::Vector2d(random.normal(), random.normal());
    if (!combine<2>(b, c, 0.98).fused) ++refused;
  }
  EXPECT_NEAR(refused, 0.02 * runs, 4.0 * std::sqrt(0.02 * 0.98 * runs));
}

TEST(CovarianceIntersection, OfOneAndTheSameChangesNothing) {
  RandomStream random(3, 0);
  const Gaussian<3> x = random_gaussian<3>(&random);
  const Gaussian<3> result = covariance_intersection<3>(x, x);
  EXPECT_TRUE(MatrixNear(result.mean, x.mean, 1e-9));
  EXPECT_TRUE(MatrixNear(result.covariance, x.covariance, 1e-9));
}

TEST(CovarianceIntersection, OfTwoThatKnowDifferentAxesIsTheTextbooksExample) {  // by symmetry w = 1/2
  Gaussian<2> b;
  b.covariance.diagonal() << 1.0, 4.0;
  Gaussian<2> c;
  c.covariance.diagonal() << 4.0, 1.0;
  const Gaussian<2> result = covariance_intersection<2>(b, c);
  EXPECT_TRUE(MatrixNear(result.covariance, Eigen::Matrix2d::Identity() / (0.5 / 1.0 + 0.5 / 4.0), 1e-9));
}

TEST(CovarianceIntersection, HasTheLeastDeterminantOfAllWeights) {
  RandomStream random(4, 0);
  for (int run = 0; run < 20; ++run) {
    const Gaussian<3> b = random_gaussian<3>(&random);
    const Gaussian<3> c = random_gaussian<3>(&random);
    const double found = covariance_intersection<3>(b, c).covariance.determinant();
    for (double w = 0.0; w <= 1.0; w += 0.01) {
      const Eigen::Matrix3d information = w * b.covariance.inverse() + (1.0 - w) * c.covariance.inverse();
      EXPECT_LE(found, 1.0 / information.determinant() * (1.0 + 1e-9));
    }
  }
}

/// Whatever the correlation C: the true covariance of the mean, with C in it, never exceeds the one told.
TEST(CovarianceIntersection, IsNeverTooSure) {
  RandomStream random(5, 0);
  for (int run = 0; run < 50; ++run) {
    const Gaussian<2> b = random_gaussian<2>(&random);
    const Gaussian<2> c = random_gaussian<2>(&random);
    const Gaussian<2> result = covariance_intersection<2>(b, c);
    EXPECT_TRUE(IsCovariance(result.covariance));
    // mean = K_b b + K_c c with K_b + K_c = I; K_c from the response to a moved c.
    Eigen::Matrix2d K_c;
    for (int i = 0; i < 2; ++i) {
      Gaussian<2> moved = c;
      moved.mean += Eigen::Vector2d::Unit(i);
      K_c.col(i) = covariance_intersection<2>(b, moved).mean - result.mean;
    }
    const Eigen::Matrix2d K_b = Eigen::Matrix2d::Identity() - K_c;
    const double angle = random.uniform(-kPi, kPi);
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
    const Eigen::Matrix2d root_b = b.covariance.llt().matrixL();
    const Eigen::Matrix2d root_c = c.covariance.llt().matrixL();
    const Eigen::Matrix2d C = root_b * turn * root_c.transpose();  // as correlated as can be
    const Eigen::Matrix2d truth = K_b * b.covariance * K_b.transpose() +
                                  K_c * c.covariance * K_c.transpose() + K_b * C * K_c.transpose() +
                                  K_c * C.transpose() * K_b.transpose();
    const Eigen::Vector2d surplus =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(result.covariance - truth).eigenvalues();
    EXPECT_GT(surplus.minCoeff(), -1e-9);
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
