#include "kinect_ekf_slam/study/consistency_study.h"

#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {
namespace {

using Type = EstimatorOptions::Type;

/// The whole of it, 50 seeds and ten loops, is `slam_study consistency`; here as much as a test has time for.
template <class Space>
std::vector<ConsistencyResult> study(int seeds, int loops) {
  ConsistencyScenario scenario;
  scenario.loops = loops;
  return run_consistency<Space>(scenario, {Type::kEkf, Type::kInvariantEkf}, seeds, {});
}

template <class Space>
void expect_that_only_the_invariant_filter_is_consistent(const std::vector<ConsistencyResult>& results) {
  const ConsistencyResult& ekf = results[0];
  const ConsistencyResult& invariant = results[1];
  EXPECT_GT(ekf.pose.mean, 1.5 * invariant.pose.mean);
  EXPECT_LT(invariant.pose.mean, 3.7 / 3.0 * Space::kPoseDim);
  EXPECT_GT(invariant.pose.inside_share, 0.8);
  EXPECT_LT(invariant.position_rmse, ekf.position_rmse);
}

TEST(ConsistencyStudy, InThePlaneOnlyTheInvariantFilterIsConsistent) {
  expect_that_only_the_invariant_filter_is_consistent<Planar>(study<Planar>(20, 8));
}

TEST(ConsistencyStudy, InSpaceOnlyTheInvariantFilterIsConsistent) {
  expect_that_only_the_invariant_filter_is_consistent<Spatial>(study<Spatial>(20, 3));
}

TEST(ConsistencyStudy, TheSameSeedsGiveTheSameFigures) {
  EXPECT_EQ(to_json(study<Planar>(2, 1)), to_json(study<Planar>(2, 1)));
}

}  // namespace
}  // namespace kinect_ekf_slam
