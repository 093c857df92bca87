#include "kinect_ekf_slam/core/se3.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::PoseNear;

Eigen::Vector3d random_vector(std::mt19937_64* random, double largest) {
  std::uniform_real_distribution<double> any(-largest, largest);
  return Eigen::Vector3d::NullaryExpr([&] { return any(*random); });
}

Se3 random_pose(std::mt19937_64* random) {
  return {random_vector(random, 5.0), rotation_exp(random_vector(random, 3.0))};
}

Se3::Tangent twist_of(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation) {
  return (Se3::Tangent() << translation, rotation).finished();
}

TEST(Hat, IsTheCrossProduct) {
  const Eigen::Vector3d a(0.3, -1.2, 2.0);
  const Eigen::Vector3d b(-0.7, 0.4, 1.1);
  EXPECT_TRUE(MatrixNear(hat(a) * b, a.cross(b), 1e-15));
}

TEST(Rotation, ExpTurnsAboutTheVector) {
  const Eigen::Vector3d vector(0.4, -0.9, 0.7);
  const Eigen::AngleAxisd expected(vector.norm(), vector.normalized());
  EXPECT_TRUE(MatrixNear(rotation_exp(vector).toRotationMatrix(), expected.toRotationMatrix(), 1e-15));
  EXPECT_TRUE(
      MatrixNear(rotation_exp(Eigen::Vector3d::Zero()).toRotationMatrix(), Eigen::Matrix3d::Identity(), 0.0));
}

TEST(Rotation, ExpAndLogAreInverseForAnyAngle) {
  std::mt19937_64 random(1);
  for (const double angle :
       {0.0, 1e-300, 1e-12, 1e-7, 1.9e-4, 2.1e-4, 0.1, 1.5, 3.0, kPi - 1e-6, kPi - 1e-9}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d vector = angle * random_vector(&random, 1.0).normalized();
      const Eigen::Quaterniond rotation = rotation_exp(vector);
      EXPECT_TRUE(MatrixNear(rotation_log(rotation), vector, 1e-12)) << angle;
      const Eigen::Quaterniond other_sign(Eigen::Vector4d(-rotation.coeffs()));
      EXPECT_TRUE(MatrixNear(rotation_log(other_sign), vector, 1e-12)) << angle << ", the same rotation";
    }
  }
}

/// At half a turn both directions are the shortest: either will do, as long as it is that rotation.
TEST(Rotation, LogOfHalfATurnIsHalfATurn) {
  std::mt19937_64 random(2);
  for (const double angle : {kPi, kPi + 1e-9, kPi + 1e-3}) {
    const Eigen::Quaterniond rotation = rotation_exp(angle * random_vector(&random, 1.0).normalized());
    const Eigen::Vector3d vector = rotation_log(rotation);
    EXPECT_LE(vector.norm(), kPi + 1e-15);
    EXPECT_TRUE(MatrixNear(rotation_exp(vector).toRotationMatrix(), rotation.toRotationMatrix(), 1e-12));
  }
}

TEST(Se3, ExpAndLogAreInverse) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    Se3::Tangent twist = twist_of(random_vector(&random, 3.0), random_vector(&random, 1.8));
    if (twist.tail<3>().norm() > 3.1) continue;
    if (i % 3 == 0) twist.tail<3>() *= 1e-7;                                   // almost straight
    if (i % 3 == 1) twist.tail<3>() *= (kPi - 1e-6) / twist.tail<3>().norm();  // almost half a turn
    EXPECT_TRUE(MatrixNear(Se3::exp(twist).log(), twist, 1e-8));
  }
}

TEST(Se3, ExpIsTheLimitOfSmallSteps) {
  const Se3::Tangent twist = twist_of({0.7, -0.2, 0.4}, {0.9, -1.1, 1.3});
  Se3 small_steps;
  const Se3 step({0.7e-3, -0.2e-3, 0.4e-3}, rotation_exp(1e-3 * twist.tail<3>()));
  for (int i = 0; i < 1000; ++i) small_steps = small_steps * step;
  EXPECT_TRUE(PoseNear(Se3::exp(twist), small_steps, 2e-3));
}

/// The series near zero meets the closed form where one hands over to the other.
TEST(Se3, ExpIsSmoothThroughItsSeries) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  for (const double angle : {0.99e-4, 1.01e-4, 1.99e-4, 2.01e-4}) {
    const Se3 halves = Se3::exp(0.5 * twist_of({1.0, 2.0, 3.0}, angle * axis));
    EXPECT_TRUE(PoseNear(Se3::exp(twist_of({1.0, 2.0, 3.0}, angle * axis)), halves * halves, 1e-12));
  }
}

TEST(Se3, GroupLaws) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 200; ++i) {
    const Se3 a = random_pose(&random);
    const Se3 b = random_pose(&random);
    const Se3 c = random_pose(&random);
    EXPECT_TRUE(PoseNear((a * b) * c, a * (b * c), 1e-12));
    EXPECT_TRUE(PoseNear(a * a.inverse(), Se3(), 1e-12));
    const Eigen::Vector3d point(1.0, 2.0, -3.0);
    EXPECT_TRUE(MatrixNear((a * b) * point, a * (b * point), 1e-12));
  }
}

TEST(Se3, StaysARotationThroughAMillionSteps) {
  const Se3 step = Se3::exp(twist_of({0.01, 0.0, 0.002}, {0.01, -0.02, 0.03}));
  Se3 pose;
  for (int i = 0; i < 1000000; ++i) pose = pose * step;
  EXPECT_TRUE(MatrixNear(pose.rotation() * pose.rotation().transpose(), Eigen::Matrix3d::Identity(), 1e-14));
}

TEST(Se3, AdjointMovesAPerturbationAcross) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const Se3 pose = random_pose(&random);
    const Se3::Tangent twist = 1e-3 * random_pose(&random).log();
    EXPECT_TRUE(PoseNear(pose * Se3::exp(twist), Se3::exp(pose.adjoint() * twist) * pose, 1e-12));
  }
}

TEST(Se3, InThePlaneIsSe2) {
  const Se2 planar = Se2::exp({0.7, -0.2, 1.3});
  const Se3 spatial = Se3::exp(twist_of({0.7, -0.2, 0.0}, {0.0, 0.0, 1.3}));
  EXPECT_TRUE(MatrixNear(spatial.translation().head<2>(), planar.translation(), 1e-15));
  EXPECT_TRUE(MatrixNear(spatial.rotation().topLeftCorner(2, 2), planar.rotation(), 1e-15));
  EXPECT_EQ(spatial.translation().z(), 0.0);
}

}  // namespace
}  // namespace kinect_ekf_slam
