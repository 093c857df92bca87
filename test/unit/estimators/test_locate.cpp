/// Positions and ranges as updates: every Kalman estimator, every space.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::pose_at;
using testing::Scenario;
using Type = EstimatorOptions::Type;

constexpr double kWideGate = 1e9;

template <class SpaceType, Type kTypeValue>
struct Case {
  using Space = SpaceType;
  static constexpr Type kType = kTypeValue;
};
using Cases = ::testing::Types<Case<Planar, Type::kEkf>, Case<Planar, Type::kInvariantEkf>,
                               Case<Planar, Type::kCompressedEkf>, Case<Planar, Type::kUkf>,
                               Case<Spatial, Type::kEkf>, Case<Spatial, Type::kInvariantEkf>,
                               Case<Spatial, Type::kCompressedEkf>, Case<Spatial, Type::kUkf>>;

template <class TestCase>
class Locate : public ::testing::Test {
 protected:
  using TestSpace = typename TestCase::Space;
  using Pose = typename TestSpace::Pose;
  using Point = typename TestSpace::Point;
  using PointMatrix = typename TestSpace::PointMatrix;
  using Estimator = std::unique_ptr<SlamEstimator<TestSpace>>;

  static Estimator make(const PoseEstimate<TestSpace>& initial) {
    return make_estimator<TestSpace>(testing::textbook(TestCase::kType), testing::known_identities(),
                                     initial);
  }
  static PositionMeasurement<TestSpace> position(const Eigen::Vector3d& place, double sigma) {
    GlobalPosition measured;
    measured.position_in_map = place;
    measured.covariance = sigma * sigma * Eigen::Matrix<double, 6, 6>::Identity();
    return PositionMeasurement<TestSpace>(measured);
  }
  /// In the plane, and in space at three heights, or nothing would tell the robot's.
  static std::vector<Point> beacons() {
    return {TestSpace::from_3d(Eigen::Vector3d(-6.0, -5.0, 4.0)),
            TestSpace::from_3d(Eigen::Vector3d(7.0, -6.0, -3.0)),
            TestSpace::from_3d(Eigen::Vector3d(1.0, 8.0, 5.0)),
            TestSpace::from_3d(Eigen::Vector3d(-9.0, 7.0, -6.0))};
  }
  /// Mean of `count` values with `dof` degrees of freedom each inside its 99.9 % bounds.
  static ::testing::AssertionResult IsConsistent(double sum, int dof, int count) {
    const double low = chi_square_quantile(0.0005, dof * count);
    const double high = chi_square_quantile(0.9995, dof * count);
    if (low <= sum && sum <= high) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "mean NEES " << sum / count << " of " << dof << ", outside ["
                                         << low / count << ", " << high / count << "]";
  }
};
TYPED_TEST_SUITE(Locate, Cases);

/// Without a lever arm h is the position itself: the linear Kalman filter, also where the error of sightings
/// is not.
TYPED_TEST(Locate, APositionIsAveragedWithTheEstimateByTheirVariances) {
  using Space = typename TypeParam::Space;
  constexpr int kPointDim = Space::kPointDim;
  const auto estimator = this->make(pose_at<Space>(typename Space::Pose(), 0.3));
  const auto report = estimator->locate(this->position({1.0, -2.0, 0.5}, 0.4), kNoId, kWideGate);
  EXPECT_EQ(report.verdict, PositionVerdict::kUsed);
  const typename Space::Point z = Space::from_3d(Eigen::Vector3d(1.0, -2.0, 0.5));
  EXPECT_NEAR(report.squared_distance, z.squaredNorm() / 0.25, 1e-8);
  const auto pose = estimator->pose();
  EXPECT_TRUE(MatrixNear(pose.map_from_base.translation(), z * 0.09 / 0.25, 1e-8));
  EXPECT_TRUE(MatrixNear(pose.covariance.template topLeftCorner<kPointDim, kPointDim>(),
                         0.09 * 0.16 / 0.25 * Space::PointMatrix::Identity(), 1e-8));
}

TYPED_TEST(Locate, APositionOutsideTheGateChangesNothing) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make(pose_at<Space>(typename Space::Pose(), 0.3));
  const auto before = estimator->snapshot();
  const auto report = estimator->locate(this->position({20.0, 0.0, 0.0}, 1.0), kNoId, 14.0);
  EXPECT_EQ(report.verdict, PositionVerdict::kOutsideGate);
  EXPECT_NEAR(report.squared_distance, 400.0 / 1.09, 1e-6);
  const auto after = estimator->snapshot();
  EXPECT_TRUE(MatrixNear(Space::to_vector(after.map_from_base), Space::to_vector(before.map_from_base), 0.0));
  EXPECT_TRUE(MatrixNear(after.covariance, before.covariance, 0.0));
}

TYPED_TEST(Locate, AFixedMapStaysAsItIs) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make(pose_at<Space>(typename Space::Pose(), 0.3));
  estimator->observe(1, {testing::seen<Space>(Space::from_3d(Eigen::Vector3d(2.0, 1.0, 0.5)), 5)});
  estimator->set_map_fixed(true);
  const auto before = estimator->snapshot();
  EXPECT_EQ(estimator->locate(this->position({0.3, 0.2, 0.1}, 0.1), kNoId, kWideGate).verdict,
            PositionVerdict::kUsed);
  const auto after = estimator->snapshot();
  constexpr int kPoint = Space::kPointDim;
  EXPECT_GT((after.map_from_base.translation() - before.map_from_base.translation()).norm(), 0.2);
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map, before.landmarks_in_map, 0.0));
  EXPECT_TRUE(MatrixNear(after.covariance.bottomRightCorner(kPoint, kPoint),
                         before.covariance.bottomRightCorner(kPoint, kPoint), 0.0));
  EXPECT_TRUE(IsCovariance(after.covariance));
}

TYPED_TEST(Locate, ARangeToABeaconThatIsNotThereIsToldApart) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make(pose_at<Space>(typename Space::Pose(), 0.3));
  const RangeMeasurement<Space> range({9, 3.0, 0.01, Eigen::Vector3d::Zero()}, 0.0);
  EXPECT_EQ(estimator->locate(range, beacon_landmark_id(9), kWideGate).verdict,
            PositionVerdict::kUnknownBeacon);
}

/// Odometry and ranges alone: the source's localisation among buoys. Of the four places one is known to 1 m
/// only, and is found.
TYPED_TEST(Locate, RangesTellWhereRobotAndBeaconsAreAsSurelyAsItSays) {
  using Space = typename TypeParam::Space;
  constexpr int kSeeds = 40;
  constexpr double kRangeSigma = 0.1;
  const std::vector<double> sigmas = {0.05, 0.05, 0.05, 1.0};
  double pose_nees = 0.0;
  double beacon_nees = 0.0;
  double squared_error = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Scenario<Space> scenario(static_cast<std::uint64_t>(seed), 0);
    RandomStream random(static_cast<std::uint64_t>(seed), 1);
    const PoseEstimate<Space> initial = pose_at<Space>(typename Space::Pose(), 0.1);
    scenario.start_at(initial);
    const auto estimator = this->make(initial);
    std::vector<typename Space::Point> places = this->beacons();
    for (std::size_t i = 0; i < places.size(); ++i) {
      estimator->add_landmark(beacon_landmark_id(static_cast<int>(i)), places[i],
                              sigmas[i] * sigmas[i] * Space::PointMatrix::Identity());
      places[i] += Space::Point::NullaryExpr([&] { return sigmas[i] * random.normal(); });
    }
    for (int step = 0; step < 120; ++step) {
      estimator->predict(scenario.drive(testing::gentle_curve<Space>()));
      const auto beacon = static_cast<std::size_t>(step) % places.size();
      BeaconRange measured{static_cast<int>(beacon), 0.0, kRangeSigma * kRangeSigma, {0.2, -0.1, 0.3}};
      measured.range =
          RangeMeasurement<Space>(measured, 0.3).expected_range(scenario.true_pose(), places[beacon]) +
          kRangeSigma * random.normal();
      const auto report = estimator->locate(RangeMeasurement<Space>(measured, 0.3),
                                            beacon_landmark_id(measured.beacon), kWideGate);
      ASSERT_EQ(report.verdict, PositionVerdict::kUsed);
    }
    ASSERT_TRUE(IsCovariance(estimator->snapshot().covariance));
    pose_nees += testing::nees(scenario, estimator->pose());
    const auto rough = estimator->landmarks().back();
    const typename Space::Point error = rough.position_in_map - places.back();
    beacon_nees += error.dot(rough.covariance.llt().solve(error));
    squared_error += error.squaredNorm();
  }
  EXPECT_TRUE(this->IsConsistent(pose_nees, Space::kPoseDim, kSeeds));
  EXPECT_TRUE(this->IsConsistent(beacon_nees, Space::kPointDim, kSeeds));
  EXPECT_LT(std::sqrt(squared_error / kSeeds), 0.4 * sigmas.back() * std::sqrt(Space::kPointDim));
}

TYPED_TEST(Locate, WhereRobotAndMapLieTogetherIsLoosened) {
  using Space = typename TypeParam::Space;
  constexpr int kPointDim = Space::kPointDim;
  const auto estimator = this->make(pose_at<Space>(typename Space::Pose(), 0.3));
  const typename Space::Point place = Space::from_3d(Eigen::Vector3d(3.0, 4.0, 0.0));
  estimator->add_landmark(beacon_landmark_id(0), place, Space::PointMatrix::Identity());
  typename Space::PoseMatrix loose = Space::PoseMatrix::Zero();
  loose.diagonal().setConstant(4.0);
  loose(Space::kPoseDim - 1, Space::kPoseDim - 1) = 0.01;  // heading
  loose.template block<Space::kTurnDim - 1, Space::kTurnDim - 1>(kPointDim, kPointDim).setZero();
  const auto before = estimator->snapshot();
  estimator->loosen(loose);
  const auto after = estimator->snapshot();
  EXPECT_TRUE(IsCovariance(after.covariance));
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map, before.landmarks_in_map, 1e-12));
  // The robot is at the origin: it turns where it stands, and the beacon 5 m away moves by 5 m a radian.
  const Eigen::MatrixXd added = after.covariance - before.covariance;
  EXPECT_TRUE(MatrixNear(added.topLeftCorner(Space::kPoseDim, Space::kPoseDim), loose, 1e-9));
  const int row = Space::kPoseDim;
  EXPECT_NEAR(added(row, row), 4.0 + 0.01 * 16.0, 1e-9);
  EXPECT_NEAR(added(row + 1, row + 1), 4.0 + 0.01 * 9.0, 1e-9);
  EXPECT_NEAR(added(row, row + 1), -0.01 * 12.0, 1e-9);
  EXPECT_NEAR(added(row, 0), 4.0, 1e-9);
  EXPECT_NEAR(added(row, Space::kPoseDim - 1), -0.01 * 4.0, 1e-9);
}

/// The sighting of a thing that stands where a beacon is.
TEST(LocatePlanar, NobodySeesABeacon) {
  AssociationOptions association;
  const auto estimator =
      make_estimator<Planar>(testing::textbook(), association, pose_at<Planar>(Se2(), 0.01));
  estimator->add_landmark(beacon_landmark_id(0), {2.0, 0.0}, 0.01 * Eigen::Matrix2d::Identity());
  const auto report = estimator->observe(1, {testing::seen<Planar>({2.0, 0.0}, kNoId)});
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kCreated);
}

}  // namespace
}  // namespace kinect_ekf_slam
