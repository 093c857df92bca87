#include "kinect_ekf_slam/estimators/dead_reckoning.h"

#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::motion;
using testing::pose_at;
using testing::PoseNear;
using testing::seen;

std::unique_ptr<SlamEstimator<Planar>> make() {
  return make_estimator<Planar>(testing::textbook(EstimatorOptions::Type::kDeadReckoning),
                                testing::known_identities(), pose_at<Planar>(Se2(), 0.01));
}

TEST(DeadReckoning, NothingSeenCorrectsThePose) {
  const auto open_loop = make();
  open_loop->observe(1, {seen<Planar>({2.0, 0.0}, 1)});
  open_loop->predict(motion<Planar>(Se2(0.5, 0.0, 0.1), 0.1));
  const PoseEstimate<Planar> before = open_loop->pose();
  const UpdateReport report = open_loop->observe(2, {seen<Planar>({1.9, 0.3}, 1)});
  EXPECT_EQ(report.dof, 0);
  EXPECT_TRUE(PoseNear(open_loop->pose().map_from_base, before.map_from_base, 0.0));
  EXPECT_TRUE(MatrixNear(open_loop->pose().covariance, before.covariance, 0.0));
}

TEST(DeadReckoning, PlotsLandmarksWhereTheyWereSeenLast) {
  const auto open_loop = make();
  open_loop->observe(1, {seen<Planar>({2.0, 0.0}, 1)});
  open_loop->predict(motion<Planar>(Se2(1.0, 0.0, 0.5 * kPi), 0.1));
  open_loop->observe(2, {seen<Planar>({0.5, 0.2}, 1)});
  ASSERT_EQ(open_loop->landmarks().size(), 1U);
  EXPECT_TRUE(MatrixNear(open_loop->landmarks()[0].position_in_map, Eigen::Vector2d(0.8, 0.5), 1e-12));
}

TEST(DeadReckoning, ObeysAnIdentityThatTheGateWouldRefuse) {
  const auto open_loop = make();
  const int landmark = open_loop->observe(1, {seen<Planar>({2.0, 0.0}, 1)}).assignments[0].landmark;
  const UpdateReport report = open_loop->observe(2, {seen<Planar>({-5.0, 4.0}, 1)});
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kMatched);
  EXPECT_EQ(report.assignments[0].landmark, landmark);
  EXPECT_TRUE(MatrixNear(open_loop->landmarks()[0].position_in_map, Eigen::Vector2d(-5.0, 4.0), 1e-12));
}

TEST(DeadReckoning, OfTwoSightingsOfOneLandmarkTheBetterCounts) {
  const auto good = seen<Planar>({2.05, 0.0}, 1);
  const auto bad = seen<Planar>({-5.0, 4.0}, 1);
  for (const auto& sightings : {std::vector{good, bad}, std::vector{bad, good}}) {
    const auto open_loop = make();
    open_loop->observe(1, {seen<Planar>({2.0, 0.0}, 1)});
    open_loop->observe(2, sightings);
    EXPECT_TRUE(MatrixNear(open_loop->landmarks()[0].position_in_map, good.position_in_base, 1e-12));
    EXPECT_EQ(open_loop->landmarks()[0].info.observations, 2U);
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
