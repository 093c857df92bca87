#include "kinect_ekf_slam/fusion/interpolation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <stdexcept>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/estimators/pose_parts.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::PoseNear;

constexpr TimeNs kSecond = 1000000000;

Gaussian<1> gaussian(double mean, double variance) {
  Gaussian<1> result;
  result.mean << mean;
  result.covariance << variance;
  return result;
}

TEST(LagrangeWeights, AreOneAtTheirOwnSampleAndNoneAtTheOthers) {
  const std::vector<TimeNs> samples = {0, kSecond, 4 * kSecond};
  EXPECT_TRUE(MatrixNear(lagrange_weights(0, samples), Eigen::Vector3d(1.0, 0.0, 0.0), 1e-15));
  EXPECT_TRUE(MatrixNear(lagrange_weights(kSecond, samples), Eigen::Vector3d(0.0, 1.0, 0.0), 1e-15));
  EXPECT_TRUE(MatrixNear(lagrange_weights(4 * kSecond, samples), Eigen::Vector3d(0.0, 0.0, 1.0), 1e-15));
}

TEST(LagrangeWeights, AreTheCorrectedFormulasNumbers) {  // by hand, t = 2 among 0, 1, 4
  const Eigen::Vector3d expected((2.0 - 1.0) * (2.0 - 4.0) / ((0.0 - 1.0) * (0.0 - 4.0)),
                                 (2.0 - 0.0) * (2.0 - 4.0) / ((1.0 - 0.0) * (1.0 - 4.0)),
                                 (2.0 - 0.0) * (2.0 - 1.0) / ((4.0 - 0.0) * (4.0 - 1.0)));
  EXPECT_TRUE(MatrixNear(lagrange_weights(2 * kSecond, {0, kSecond, 4 * kSecond}), expected, 1e-15));
}

TEST(LagrangeWeights, OfTwoSamplesAreTheStraightLine) {
  EXPECT_TRUE(MatrixNear(lagrange_weights(kSecond, {0, 4 * kSecond}), Eigen::Vector2d(0.75, 0.25), 1e-15));
}

TEST(LagrangeWeights, RefuseTwoSamplesOfOneTimeAndNone) {
  EXPECT_THROW(lagrange_weights(0, {kSecond, kSecond}), std::invalid_argument);
  EXPECT_THROW(lagrange_weights(0, {}), std::invalid_argument);
}

TEST(Interpolation, OfThreePositionsIsExactOnAParabola) {
  const auto x = [](double t) { return 3.0 - 2.0 * t + 0.5 * t * t; };
  std::vector<Stamped<Gaussian<1>>> samples;
  for (const int t : {0, 1, 4}) samples.push_back({t * kSecond, gaussian(x(t), 1.0 + t)});
  const Gaussian<1> at = interpolate<1>(samples, 2 * kSecond);
  EXPECT_NEAR(at.mean(0), x(2.0), 1e-12);
  const Eigen::Vector3d xi = lagrange_weights(2 * kSecond, {0, kSecond, 4 * kSecond});
  EXPECT_NEAR(at.covariance(0), xi.cwiseAbs2().dot(Eigen::Vector3d(1.0, 2.0, 5.0)), 1e-12);
}

template <class Space>
class InterpolationOfPoses : public ::testing::Test {
 protected:
  using Pose = typename Space::Pose;
  using PoseVector = typename Space::PoseVector;

  /// A steady turn, and a parabola.
  static Pose way(double t) {
    typename Space::PoseVector turn = Space::PoseVector::Zero();
    turn.template tail<Space::kTurnDim>().setConstant(0.4 * t);
    typename Space::Point position = Space::Point::Constant(0.3 * t * t);
    position(0) += 2.0 - t;
    return pose_from_parts<Space>(position, Pose::exp(turn));
  }
  static PoseEstimate<Space> estimate(double t, double sigma) {
    PoseEstimate<Space> result{way(t)};
    result.covariance.setConstant(0.3 * sigma * sigma);
    result.covariance.diagonal().setConstant(sigma * sigma);
    return result;
  }
};
TYPED_TEST_SUITE(InterpolationOfPoses, testing::Spaces, testing::SpaceNames);

TYPED_TEST(InterpolationOfPoses, IsExactOnASteadyTurnAndAParabola) {
  using Space = TypeParam;
  std::vector<Stamped<PoseEstimate<Space>>> samples;
  for (const int t : {0, 1, 4}) samples.push_back({t * kSecond, TestFixture::estimate(t, 0.1)});
  for (const double t : {0.0, 0.5, 1.0, 2.7, 4.0}) {
    EXPECT_TRUE(
        PoseNear(interpolate<Space>(samples, to_nanoseconds(t)).map_from_base, TestFixture::way(t), 1e-9));
  }
}

TYPED_TEST(InterpolationOfPoses, AtASampleIsThatSample) {
  using Space = TypeParam;
  std::vector<Stamped<PoseEstimate<Space>>> samples;
  for (const int t : {0, 1, 4}) samples.push_back({t * kSecond, TestFixture::estimate(t, 0.1 * (1 + t))});
  for (const auto& sample : samples) {
    EXPECT_TRUE(
        MatrixNear(interpolate<Space>(samples, sample.stamp).covariance, sample.value.covariance, 1e-9));
  }
}

/// Samples that turn far between them, so that the turn's covariance is not that of a plain sum.
TYPED_TEST(InterpolationOfPoses, KnowsItsErrors) {
  using Space = TypeParam;
  RandomStream random(1, 0);
  const TimeNs stamp = to_nanoseconds(2.7);
  const int runs = 1000;
  double nees = 0.0;
  for (int run = 0; run < runs; ++run) {
    std::vector<Stamped<PoseEstimate<Space>>> samples;
    for (const int t : {0, 1, 4}) {
      PoseEstimate<Space> sample = TestFixture::estimate(t, 0.02);
      typename Space::PoseVector noise;
      for (double& number : noise) number = random.normal();
      const typename Space::PoseMatrix L = sample.covariance.llt().matrixL();
      sample.map_from_base = moved_by_error<Space>(sample.map_from_base, L * noise);
      samples.push_back({t * kSecond, sample});
    }
    const PoseEstimate<Space> result = interpolate<Space>(samples, stamp);
    ASSERT_TRUE(IsCovariance(result.covariance));
    const auto error = pose_error<Space>(result.map_from_base, TestFixture::way(2.7));
    nees += error.dot(result.covariance.llt().solve(error));
  }
  EXPECT_GT(nees, chi_square_quantile(0.001, Space::kPoseDim * runs));
  EXPECT_LT(nees, chi_square_quantile(0.999, Space::kPoseDim * runs));
}

}  // namespace
}  // namespace kinect_ekf_slam
