#include "kinect_ekf_slam/simulation/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/support/matchers.h"

namespace kinect_ekf_slam::testing {
namespace {

const Points2d kTruth = {{0.0, 0.0}, {3.0, 0.5}, {2.0, 2.5}, {-1.0, 2.0}};

Points2d moved(const Points2d& points, const Se2& motion) {
  Points2d result;
  for (const Eigen::Vector2d& point : points) result.push_back(motion * point);
  return result;
}

TEST(Alignment, FindsTheMotion) {
  const Se2 motion(0.7, -1.2, 2.5);
  EXPECT_TRUE(PoseNear(align(moved(kTruth, motion), kTruth), motion, 1e-12));
  EXPECT_TRUE(PoseNear(align({{1.0, 2.0}}, {{0.5, 0.5}}), Se2(0.5, 1.5, 0.0), 1e-12));
  EXPECT_TRUE(PoseNear(align({}, {}), Se2(), 0.0));
}

TEST(MapComparison, AMovedMapIsExactAfterTheAlignment) {
  const MapComparison comparison = compare_maps(kTruth, moved(kTruth, Se2(0.1, -0.1, 0.08)));
  EXPECT_EQ(comparison.matched, 4U);
  EXPECT_NEAR(comparison.rmse_aligned, 0.0, 1e-12);
  EXPECT_GT(comparison.rmse, 0.1);
}

TEST(MapComparison, CountsWhatIsMissedAndWhatIsTooMuch) {
  Points2d estimate = kTruth;
  estimate.pop_back();
  estimate.emplace_back(6.0, 6.0);
  estimate.emplace_back(3.2, 0.5);  // a second one where there is one
  const MapComparison comparison = compare_maps(kTruth, estimate);
  EXPECT_EQ(comparison.matched, 3U);
  EXPECT_EQ(comparison.missed(), 1U);
  EXPECT_EQ(comparison.spurious(), 2U);
  EXPECT_NEAR(comparison.rmse_aligned, 0.0, 1e-12);
}

TEST(MapComparison, IsTheRootOfTheMeanSquare) {
  // Two errors along the line between the points stay after the alignment, as nothing stretches.
  const MapComparison comparison = compare_maps({{0.0, 0.0}, {2.0, 0.0}}, {{-0.1, 0.0}, {2.1, 0.0}});
  EXPECT_NEAR(comparison.rmse_aligned, 0.1, 1e-12);
  EXPECT_NEAR(comparison.max_aligned, 0.1, 1e-12);
}

TEST(MapComparison, WithoutPairsThereIsNoFigure) {
  EXPECT_TRUE(std::isnan(compare_maps(kTruth, {}).rmse_aligned));
  EXPECT_EQ(compare_maps(kTruth, {{9.0, 9.0}}).spurious(), 1U);
}

}  // namespace
}  // namespace kinect_ekf_slam::testing
