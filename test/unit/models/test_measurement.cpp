#include "kinect_ekf_slam/models/measurement.h"

#include <gtest/gtest.h>

#include <random>

#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::numerical_jacobian;

TEST(Measurement, IsTheLandmarkSeenFromTheRobot) {
  const Se2 map_from_base(1.0, 2.0, 0.5 * kPi);
  const auto predicted = predict_point<Planar>(map_from_base, {1.0, 5.0});  // 3 m ahead
  EXPECT_TRUE(MatrixNear(predicted.point_in_base, Eigen::Vector2d(3.0, 0.0), 1e-12));
}

TEST(Measurement, JacobiansMatchNumericalDifferentiation) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  for (int i = 0; i < 100; ++i) {
    const Se2 pose(any(random), any(random), any(random));
    const Eigen::Vector2d landmark(any(random), any(random));
    const auto predicted = predict_point<Planar>(pose, landmark);
    const auto by_pose = [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd {
      return predict_point<Planar>(pose * Se2::exp(xi), landmark).point_in_base;
    };
    const auto by_landmark = [&](const Eigen::VectorXd& shift) -> Eigen::VectorXd {
      return predict_point<Planar>(pose, landmark + shift).point_in_base;
    };
    EXPECT_TRUE(MatrixNear(predicted.by_pose, numerical_jacobian(by_pose, Eigen::VectorXd::Zero(3)), 1e-7));
    EXPECT_TRUE(
        MatrixNear(predicted.by_landmark, numerical_jacobian(by_landmark, Eigen::VectorXd::Zero(2)), 1e-7));
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
