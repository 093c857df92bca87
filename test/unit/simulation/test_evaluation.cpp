#include "kinect_ekf_slam/simulation/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam::testing {
namespace {

template <class Space>
Points<Space> points(const std::vector<Eigen::Vector3d>& places) {
  Points<Space> points;
  for (const Eigen::Vector3d& place : places) points.push_back(Space::from_3d(place));
  return points;
}

template <class Space>
Points<Space> some_map() {
  return points<Space>({{0.0, 0.0, 0.5}, {3.0, 0.5, 1.5}, {2.0, 2.5, 0.2}, {-1.0, 2.0, 1.0}});
}

template <class Space>
Points<Space> moved(const Points<Space>& points, const typename Space::Pose& motion) {
  Points<Space> result;
  for (const auto& point : points) result.push_back(motion * point);
  return result;
}

/// A motion whose every component is of that size or smaller.
template <class Space>
typename Space::Pose motion(double size) {
  typename Space::PoseVector twist;
  for (int i = 0; i < Space::kPoseDim; ++i) twist(i) = size * (i % 2 == 0 ? 1.0 : -0.8);
  return Space::Pose::exp(twist);
}

template <class SpaceType>
class Evaluation : public ::testing::Test {};
TYPED_TEST_SUITE(Evaluation, Spaces, SpaceNames);

TYPED_TEST(Evaluation, AlignmentFindsTheMotion) {
  using Space = TypeParam;
  const auto expected = motion<Space>(1.4);
  const auto found = align<Space>(moved<Space>(some_map<Space>(), expected), some_map<Space>());
  EXPECT_TRUE(PoseNear(found, expected, 1e-12));
}

TYPED_TEST(Evaluation, AlignmentOfOnePairOnlyShifts) {
  using Space = TypeParam;
  const auto found = align<Space>(points<Space>({{1.0, 2.0, 3.0}}), points<Space>({{0.5, 0.5, 0.5}}));
  EXPECT_TRUE(MatrixNear(found.translation(), Space::from_3d(Eigen::Vector3d(0.5, 1.5, 2.5)), 1e-12));
  EXPECT_TRUE(MatrixNear(found.rotation(), Space::PointMatrix::Identity(), 1e-12));
  EXPECT_TRUE(PoseNear(align<Space>({}, {}), typename Space::Pose(), 0.0));
}

TYPED_TEST(Evaluation, AMovedMapIsExactAfterTheAlignment) {
  using Space = TypeParam;
  const Points<Space> truth = some_map<Space>();
  const MapComparison comparison = compare_maps<Space>(truth, moved<Space>(truth, motion<Space>(0.08)));
  EXPECT_EQ(comparison.matched, 4U);
  EXPECT_NEAR(comparison.rmse_aligned, 0.0, 1e-12);
  EXPECT_GT(comparison.rmse, 0.1);
}

TYPED_TEST(Evaluation, CountsWhatIsMissedAndWhatIsTooMuch) {
  using Space = TypeParam;
  Points<Space> estimate = some_map<Space>();
  estimate.pop_back();
  estimate.push_back(Space::from_3d(Eigen::Vector3d(6.0, 6.0, 1.0)));
  estimate.push_back(Space::from_3d(Eigen::Vector3d(3.2, 0.5, 1.5)));  // a second one where there is one
  const MapComparison comparison = compare_maps<Space>(some_map<Space>(), estimate);
  EXPECT_EQ(comparison.matched, 3U);
  EXPECT_EQ(comparison.missed(), 1U);
  EXPECT_EQ(comparison.spurious(), 2U);
  EXPECT_NEAR(comparison.rmse_aligned, 0.0, 1e-12);
}

TYPED_TEST(Evaluation, IsTheRootOfTheMeanSquare) {
  using Space = TypeParam;
  // Two errors along the line between the points stay after the alignment, as nothing stretches.
  const MapComparison comparison = compare_maps<Space>(points<Space>({{0.0, 0.0, 1.0}, {2.0, 0.0, 1.0}}),
                                                       points<Space>({{-0.1, 0.0, 1.0}, {2.1, 0.0, 1.0}}));
  EXPECT_NEAR(comparison.rmse_aligned, 0.1, 1e-12);
  EXPECT_NEAR(comparison.max_aligned, 0.1, 1e-12);
}

TYPED_TEST(Evaluation, WithoutPairsThereIsNoFigure) {
  using Space = TypeParam;
  const Points<Space> truth = some_map<Space>();
  EXPECT_TRUE(std::isnan(compare_maps<Space>(truth, {}).rmse_aligned));
  EXPECT_EQ(compare_maps<Space>(truth, points<Space>({{9.0, 9.0, 9.0}})).spurious(), 1U);
}

TEST(EvaluationInSpace, AnErrorOfHeightIsAnError) {
  const Points<Spatial> truth = some_map<Spatial>();
  Points<Spatial> estimate = truth;
  estimate[1].z() += 0.3;
  EXPECT_GT(compare_maps<Spatial>(truth, estimate).rmse_aligned, 0.03);
}

}  // namespace
}  // namespace kinect_ekf_slam::testing
