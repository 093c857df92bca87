#include "kinect_ekf_slam/models/measurement.h"

#include <gtest/gtest.h>

#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::numerical_jacobian;

template <class SpaceType>
class Measurement : public ::testing::Test {};
TYPED_TEST_SUITE(Measurement, testing::Spaces, testing::SpaceNames);

TYPED_TEST(Measurement, IsTheLandmarkSeenFromTheRobot) {
  using Space = TypeParam;
  typename Space::PoseVector quarter_turn = Space::PoseVector::Zero();
  quarter_turn(Space::kPoseDim - 1) = 0.5 * kPi;
  const typename Space::Point start = Space::from_3d(Eigen::Vector3d(1.0, 2.0, 3.0));
  const typename Space::Point ahead = Space::from_3d(Eigen::Vector3d(1.0, 5.0, 3.0));
  const auto map_from_base = Space::retract(
      Space::pose_from_3d(Eigen::Isometry3d(Eigen::Translation3d(Space::to_3d(start)))), quarter_turn);
  EXPECT_TRUE(MatrixNear(predict_point<Space>(map_from_base, ahead).point_in_base,
                         Space::from_3d(Eigen::Vector3d(3.0, 0.0, 0.0)), 1e-12));
}

TYPED_TEST(Measurement, JacobiansMatchNumericalDifferentiation) {
  using Space = TypeParam;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = Pose::exp(Space::PoseVector::NullaryExpr([&] { return any(random); }));
    const Point landmark = Point::NullaryExpr([&] { return any(random); });
    const auto predicted = predict_point<Space>(pose, landmark);
    const auto by_pose = [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd {
      return predict_point<Space>(pose * Pose::exp(xi), landmark).point_in_base;
    };
    const auto by_landmark = [&](const Eigen::VectorXd& shift) -> Eigen::VectorXd {
      return predict_point<Space>(pose, landmark + shift).point_in_base;
    };
    EXPECT_TRUE(MatrixNear(predicted.by_pose,
                           numerical_jacobian(by_pose, Eigen::VectorXd::Zero(Space::kPoseDim)), 1e-7));
    EXPECT_TRUE(MatrixNear(predicted.by_landmark,
                           numerical_jacobian(by_landmark, Eigen::VectorXd::Zero(Space::kPointDim)), 1e-7));
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
