#include <gtest/gtest.h>

#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/se2.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::AngleNear;
using testing::MatrixNear;
using testing::PoseNear;

Se2 random_pose(std::mt19937_64* random) {
  std::uniform_real_distribution<double> position(-5.0, 5.0);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  return {position(*random), position(*random), angle(*random)};
}

TEST(Angles, WrapIntoHalfOpenInterval) {
  EXPECT_DOUBLE_EQ(wrap_angle(kPi), kPi);
  EXPECT_DOUBLE_EQ(wrap_angle(-kPi), kPi);
  EXPECT_NEAR(wrap_angle(3.5 * kPi), -0.5 * kPi, 1e-12);
  EXPECT_NEAR(wrap_angle(-3.5 * kPi), 0.5 * kPi, 1e-12);
}

TEST(Matchers, AngleNearSeesBothSigns) {
  EXPECT_TRUE(AngleNear(kPi - 0.01, -kPi + 0.01, 0.03));
  EXPECT_FALSE(AngleNear(1.0, 1.1, 0.05));
  EXPECT_FALSE(AngleNear(1.1, 1.0, 0.05));
}

TEST(Se2, ExpAndLogAreInverse) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d twist(any(random), any(random), any(random));
    if (i % 3 == 0) twist.z() *= 1e-7;  // almost straight
    EXPECT_TRUE(MatrixNear(Se2::exp(twist).log(), twist, 1e-9));
  }
}

TEST(Se2, ExpIsTheLimitOfSmallSteps) {
  const Eigen::Vector3d twist(0.7, -0.2, 1.3);
  Se2 small_steps;
  for (int i = 0; i < 1000; ++i) small_steps = small_steps * Se2(0.7e-3, -0.2e-3, 1.3e-3);
  EXPECT_TRUE(PoseNear(Se2::exp(twist), small_steps, 2e-3));
}

TEST(Se2, GroupLaws) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 200; ++i) {
    const Se2 a = random_pose(&random);
    const Se2 b = random_pose(&random);
    const Se2 c = random_pose(&random);
    EXPECT_TRUE(PoseNear((a * b) * c, a * (b * c), 1e-12));
    EXPECT_TRUE(PoseNear(a * a.inverse(), Se2(), 1e-12));
    const Eigen::Vector2d point(1.0, 2.0);
    EXPECT_TRUE(MatrixNear((a * b) * point, a * (b * point), 1e-12));
  }
}

TEST(Se2, AdjointMovesAPerturbationAcross) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const Se2 pose = random_pose(&random);
    const Eigen::Vector3d twist = 1e-3 * random_pose(&random).log();
    EXPECT_TRUE(PoseNear(pose * Se2::exp(twist), Se2::exp(pose.adjoint() * twist) * pose, 1e-12));
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
