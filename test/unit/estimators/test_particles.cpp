#include "kinect_ekf_slam/estimators/particles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::AngleNear;
using testing::IsCovariance;
using testing::MatrixNear;
using testing::PoseNear;

TEST(Weights, AddUpToOneWhateverTheirSize) {
  for (const double offset : {0.0, -2000.0, 2000.0}) {
    const auto weights = normalized_weights({offset, offset + std::log(3.0)});
    EXPECT_NEAR(weights[0], 0.25, 1e-12) << offset;
    EXPECT_NEAR(weights[1], 0.75, 1e-12) << offset;
  }
}

TEST(Weights, AreEqualWhenNothingIsPossible) {
  const double never = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(normalized_weights({never, never}), (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(normalized_weights({never, 0.0}), (std::vector<double>{0.0, 1.0}));
}

TEST(EffectiveSampleSize, CountsTheParticlesThatMatter) {
  EXPECT_NEAR(effective_sample_size({0.25, 0.25, 0.25, 0.25}), 4.0, 1e-12);
  EXPECT_NEAR(effective_sample_size({0.0, 1.0, 0.0}), 1.0, 1e-12);
  EXPECT_NEAR(effective_sample_size({0.5, 0.0, 0.5}), 2.0, 1e-12);
}

/// Each index comes as often as its weight says, to less than one, whatever the random number.
TEST(LowVarianceResampling, FollowsTheWeights) {
  RandomStream random(1, 0);
  for (int run = 0; run < 200; ++run) {
    std::vector<double> log_weights;
    for (int i = 0; i < 20; ++i) log_weights.push_back(3.0 * random.normal());
    const auto weights = normalized_weights(log_weights);
    std::vector<double> counts(weights.size(), 0.0);
    for (const std::size_t index : low_variance_resample(weights, 50, random.uniform(0.0, 1.0)))
      ++counts[index];
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0.0), 50.0);
    for (std::size_t i = 0; i < weights.size(); ++i) EXPECT_LT(std::abs(counts[i] - 50.0 * weights[i]), 1.0);
  }
}

TEST(LowVarianceResampling, KeepsEquallyWeightedParticlesAsTheyAre) {
  for (const double random : {0.0, 0.3, 0.999999}) {
    EXPECT_EQ(low_variance_resample({0.25, 0.25, 0.25, 0.25}, 4, random),
              (std::vector<std::size_t>{0, 1, 2, 3}));
  }
}

TEST(LowVarianceResampling, NeverChoosesTheImpossible) {
  for (const double random : {0.0, 0.5, 0.999999}) {
    EXPECT_EQ(low_variance_resample({0.0, 1.0, 0.0}, 2, random), (std::vector<std::size_t>{1, 1}));
  }
}

TEST(CovarianceRoot, IsARootOfSingularCovariancesToo) {
  const Eigen::Vector3d v(1.0, -2.0, 0.5);
  for (const Eigen::Matrix3d& P :
       {Eigen::Matrix3d(v * v.transpose()), Eigen::Matrix3d(Eigen::Matrix3d::Zero()),
        Eigen::Matrix3d(v.cwiseAbs2().asDiagonal())}) {
    const Eigen::Matrix3d root = covariance_root(P);
    EXPECT_TRUE(MatrixNear(root * root.transpose(), P, 1e-10));
  }
}

TEST(PoseMean, IsTheMeanOnTheCircleAcrossTheSeam) {
  const std::vector<Se2> poses = {{0.0, 0.0, kPi - 0.1}, {2.0, 0.0, -kPi + 0.3}};
  const auto mean = mean_of_poses<Planar>(poses, {0.5, 0.5});
  EXPECT_TRUE(PoseNear(mean.map_from_base, Se2(1.0, 0.0, kPi + 0.1), 1e-9));
  EXPECT_NEAR(mean.covariance(0, 0), 1.0, 1e-9);
  EXPECT_NEAR(mean.covariance(2, 2), 0.04, 1e-9);
  EXPECT_NEAR(mean.covariance(0, 2), 0.2, 1e-9);
  EXPECT_TRUE(IsCovariance(mean.covariance));
}

TEST(PoseMean, OfOnePoseIsThatPose) {
  const Se2 pose(1.0, -2.0, 3.0);
  const auto mean = mean_of_poses<Planar>({pose, pose, pose}, {0.2, 0.5, 0.3});
  EXPECT_TRUE(PoseNear(mean.map_from_base, pose, 0.0));
  EXPECT_TRUE(MatrixNear(mean.covariance, Eigen::Matrix3d::Zero(), 0.0));
}

TEST(LocalDifference, IsTheInverseOfRetract) {
  const Se2 from(1.0, 2.0, 2.5);
  const Eigen::Vector3d local(0.3, -0.4, 1.2);
  EXPECT_TRUE(MatrixNear(local_difference<Planar>(from, Planar::retract(from, local)), local, 1e-12));
}

}  // namespace
}  // namespace kinect_ekf_slam
