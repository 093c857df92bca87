#include "kinect_ekf_slam/models/pose_measurement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::numerical_jacobian;

template <class Space>
class PoseMeasurements : public ::testing::Test {
 protected:
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;

  double any() { return random_.uniform(-3.0, 3.0); }
  Pose any_pose() {
    return Pose::exp(Space::PoseVector::NullaryExpr([&] { return any(); }));
  }
  Point any_point() {
    return Point::NullaryExpr([&] { return any(); });
  }
  Eigen::Vector3d any_place() { return {any(), any(), any()}; }

  /// The derivatives of h = z - nu by the pose and the point.
  static void expect_jacobians(const PoseMeasurement<Space>& measurement, const Pose& pose,
                               const Point& point, double tolerance) {
    const auto expected = measurement.expect(pose, point);
    ASSERT_TRUE(expected);
    const auto by_pose = [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd {
      return -measurement.expect(pose * Pose::exp(xi), point)->innovation;
    };
    const auto by_point = [&](const Eigen::VectorXd& shift) -> Eigen::VectorXd {
      return -measurement.expect(pose, point + shift)->innovation;
    };
    EXPECT_TRUE(MatrixNear(expected->by_pose,
                           numerical_jacobian(by_pose, Eigen::VectorXd::Zero(Space::kPoseDim)), tolerance));
    EXPECT_TRUE(MatrixNear(expected->by_point,
                           numerical_jacobian(by_point, Eigen::VectorXd::Zero(Space::kPointDim)), tolerance));
  }

 private:
  RandomStream random_{1, 0};
};
TYPED_TEST_SUITE(PoseMeasurements, testing::Spaces, testing::SpaceNames);

TYPED_TEST(PoseMeasurements, ARangeIsTheDistanceOfBeaconAndReceiver) {
  using Space = TypeParam;
  const BeaconRange measured{7, 6.0, 0.04, {0.0, 2.0, 0.5}};
  const RangeMeasurement<Space> range(measured, 0.5);
  const typename Space::Point beacon = Space::from_3d(Eigen::Vector3d(3.0, 6.0, 0.5));
  const auto expected = range.expect(typename Space::Pose(), beacon);
  ASSERT_TRUE(expected);
  EXPECT_NEAR(range.expected_range(typename Space::Pose(), beacon), 5.0, 1e-12);
  EXPECT_NEAR(expected->innovation(0), 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(range.noise()(0, 0), 0.04);
}

TEST(PlanarRange, IsTheHypotenuseWhereBeaconAndReceiverStandAtDifferentHeights) {
  const RangeMeasurement<Planar> range({0, 5.0, 0.01, {0.0, 0.0, 0.5}}, 3.5);
  EXPECT_NEAR(range.expected_range(Se2(1.0, 0.0, 2.0), {5.0, 0.0}), 5.0, 1e-12);
}

TYPED_TEST(PoseMeasurements, JacobiansOfARangeMatchNumericalDifferentiation) {
  using Space = TypeParam;
  for (int i = 0; i < 100; ++i) {
    const RangeMeasurement<Space> range({0, 4.0, 0.01, this->any_place()}, this->any());
    const auto pose = this->any_pose();
    const auto beacon = this->any_point();
    if (range.expected_range(pose, beacon) < 0.1) continue;
    this->expect_jacobians(range, pose, beacon, 1e-6);
  }
}

TYPED_TEST(PoseMeasurements, TheBendOfARangeIsItsSecondDerivative) {
  using Space = TypeParam;
  constexpr int kPointDim = Space::kPointDim;
  for (int i = 0; i < 100; ++i) {
    const RangeMeasurement<Space> range({0, 4.0, 0.01, this->any_place()}, this->any());
    const auto pose = this->any_pose();
    const auto beacon = this->any_point();
    if (range.expected_range(pose, beacon) < 0.5) continue;
    const auto expected = range.expect(pose, beacon);
    // By a shift of the robot along its axes, and of the beacon: a turn bends the lever arm's way as well.
    const auto gradient = [&](const Eigen::VectorXd& shift) -> Eigen::VectorXd {
      typename Space::PoseVector xi = Space::PoseVector::Zero();
      xi.template head<kPointDim>() = shift.head<kPointDim>();
      const auto moved = range.expect(pose * Space::Pose::exp(xi), beacon + shift.tail<kPointDim>());
      Eigen::VectorXd rows(2 * kPointDim);
      rows << moved->by_pose.template leftCols<kPointDim>().transpose(), moved->by_point.transpose();
      return rows;
    };
    Eigen::Matrix<double, kPointDim, 2 * kPointDim> W;
    W << expected->bend->by_pose.template leftCols<kPointDim>(), expected->bend->by_point;
    EXPECT_TRUE(MatrixNear(W.transpose() * W,
                           numerical_jacobian(gradient, Eigen::VectorXd::Zero(2 * kPointDim)), 1e-6));
  }
}

TYPED_TEST(PoseMeasurements, ARangeOfZeroHasNoDirection) {
  using Space = TypeParam;
  const Eigen::Vector3d receiver(0.3, -0.2, 0.1);
  const RangeMeasurement<Space> range({0, 0.0, 0.01, receiver}, receiver.z());
  const auto pose = this->any_pose();
  EXPECT_FALSE(range.expect(pose, pose * Space::from_3d(receiver)));
}

TYPED_TEST(PoseMeasurements, APositionIsThatOfTheAntenna) {
  using Space = TypeParam;
  typename Space::PoseVector quarter_turn = Space::PoseVector::Zero();
  quarter_turn(Space::kPoseDim - 1) = 0.5 * kPi;
  GlobalPosition measured;
  measured.position_in_map = {5.0, 6.0, 0.7};
  measured.antenna_in_base = {2.0, 0.0, 0.7};
  measured.covariance.diagonal() << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  const PositionMeasurement<Space> position(measured);
  const auto expected = position.expect(Space::Pose::exp(quarter_turn));  // the antenna is at (0, 2, 0.7)
  EXPECT_TRUE(MatrixNear(Eigen::VectorXd(expected->innovation),
                         Space::from_3d(Eigen::Vector3d(5.0, 4.0, 0.0)), 1e-12));
  EXPECT_TRUE(MatrixNear(position.noise(),
                         Space::from_3d(Eigen::Matrix3d(Eigen::Vector3d(1.0, 2.0, 3.0).asDiagonal())), 0.0));
}

TYPED_TEST(PoseMeasurements, JacobiansOfAPositionMatchNumericalDifferentiation) {
  using Space = TypeParam;
  for (int i = 0; i < 100; ++i) {
    GlobalPosition measured;
    measured.position_in_map = this->any_place();
    measured.antenna_in_base = this->any_place();
    const auto pose = this->any_pose();
    this->expect_jacobians(PositionMeasurement<Space>(measured), pose, Space::Point::Zero(), 1e-7);

    // An attitude's innovation is a turn, whose derivative is taken where it is small.
    measured.map_from_base = Eigen::Quaterniond(Space::to_3d(pose).linear());
    this->expect_jacobians(PositionMeasurement<Space>(measured), pose, Space::Point::Zero(), 1e-7);
  }
}

TYPED_TEST(PoseMeasurements, TheNoiseOfAnAttitudeStandsInTheAxesOfTheBase) {
  using Space = TypeParam;
  // The truth is turned a little about the map's axes, as the covariance tells.
  GlobalPosition measured;
  measured.map_from_base = Eigen::Quaterniond(Space::to_3d(this->any_pose()).linear());
  Eigen::Matrix<double, 6, 1> error;
  error << 0.1, 0.2, 0.3, 0.01, -0.02, 0.03;
  measured.covariance = error * error.transpose();
  const Eigen::Vector3d turn = Space::kTurnDim == 1 ? Eigen::Vector3d(0.0, 0.0, error(5)) : error.tail<3>();
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.linear() = rotation_exp(-turn) * measured.map_from_base->toRotationMatrix();
  truth.translation() = -error.head<3>();
  const PositionMeasurement<Space> position(measured);
  const Eigen::VectorXd innovation = position.expect(Space::pose_from_3d(truth))->innovation;
  EXPECT_TRUE(MatrixNear(position.noise(), innovation * innovation.transpose(), 1e-12));
}

}  // namespace
}  // namespace kinect_ekf_slam
