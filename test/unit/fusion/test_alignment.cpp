#include "kinect_ekf_slam/fusion/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::PoseNear;

template <class Space>
class AlignmentOf : public ::testing::Test {
 protected:
  static constexpr int kDim = Space::kPointDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;

  static Pose transform() {
    typename Space::PoseVector twist;
    for (int i = 0; i < Space::kPoseDim; ++i) twist(i) = i < kDim ? 5.0 - 3.0 * i : 0.7 + 0.4 * i;
    return Pose::exp(twist);
  }
  /// A way that winds; `width` 0: a straight line.
  static std::vector<Point> places(int count, double width = 2.0) {
    std::vector<Point> places;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d place(0.7 * i, width * std::sin(0.9 * i), width * std::cos(1.3 * i));
      places.push_back(Space::from_3d(place));
    }
    return places;
  }
  /// Local errors add up on the way, as those of a robot's path do; global ones are independent.
  static Eigen::MatrixXd local_covariance(int count) {
    Eigen::MatrixXd covariance(kDim * count, kDim * count);
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) {
        covariance.block<kDim, kDim>(kDim * i, kDim * j) =
            (1e-4 + 4e-4 * std::min(i, j)) * Space::PointMatrix::Identity();
      }
    }
    return covariance;
  }
  static AlignmentPairs<Space> exact_pairs(int count, double width = 2.0) {
    AlignmentPairs<Space> pairs;
    const std::vector<Point> local = places(count, width);
    pairs.local_points.resize(kDim * count);
    pairs.local_covariance = local_covariance(count);
    pairs.weights.setIdentity(count, count);
    for (int i = 0; i < count; ++i) {
      pairs.local_points.template segment<kDim>(kDim * i) = local[i];
      pairs.in_global.push_back({transform() * local[i], 0.04 * Space::PointMatrix::Identity()});
    }
    return pairs;
  }
  static AlignmentPairs<Space> noisy_pairs(int count, RandomStream* random) {
    AlignmentPairs<Space> pairs = exact_pairs(count);
    const auto normal = [&] { return random->normal(); };
    const Eigen::MatrixXd L = pairs.local_covariance.llt().matrixL();
    pairs.local_points += L * Eigen::VectorXd::NullaryExpr(kDim * count, normal);
    for (auto& place : pairs.in_global) {
      place.mean += place.covariance.llt().matrixL() * Point(Point::NullaryExpr(normal));
    }
    return pairs;
  }
};
TYPED_TEST_SUITE(AlignmentOf, testing::Spaces, testing::SpaceNames);

TYPED_TEST(AlignmentOf, ExactPlacesIsTheTransformItself) {
  for (const int count : {TypeParam::kPointDim + 1, 10}) {
    AlignmentOptions options;
    options.max_turn_sigma_deg = 90.0;  // few places know little
    const auto result = align_frames<TypeParam>(TestFixture::exact_pairs(count), options);
    ASSERT_TRUE(result.alignment) << result.refusal;
    EXPECT_TRUE(PoseNear(result.alignment->global_from_local.map_from_base, TestFixture::transform(), 1e-9));
    EXPECT_NEAR(result.alignment->squared_distance, 0.0, 1e-9);
  }
}

/// An antenna beside the path is as good as the path.
TYPED_TEST(AlignmentOf, PlacesBesideThePathIsTheSameTransform) {
  using Space = TypeParam;
  AlignmentPairs<Space> pairs = TestFixture::exact_pairs(12);
  for (std::size_t k = 0; k < pairs.in_global.size(); ++k) {
    const typename Space::Point offset = Space::Point::Constant(0.5 + 0.1 * static_cast<double>(k));
    pairs.offsets.push_back({offset, 1e-4 * Space::PointMatrix::Identity()});
    pairs.in_global[k].mean += TestFixture::transform().rotation() * offset;
  }
  const auto beside = align_frames<Space>(pairs, {});
  const auto on_path = align_frames<Space>(TestFixture::exact_pairs(12), {});
  ASSERT_TRUE(beside.alignment) << beside.refusal;
  EXPECT_TRUE(PoseNear(beside.alignment->global_from_local.map_from_base, TestFixture::transform(), 1e-9));
  EXPECT_GT(beside.alignment->global_from_local.covariance.trace(),
            on_path.alignment->global_from_local.covariance.trace())
      << "an offset that is not exact makes it no surer";
}

/// NEES of the transform and of transform and path together, and the residual's distance, over many runs.
TYPED_TEST(AlignmentOf, KnowsItsErrors) {
  using Space = TypeParam;
  constexpr int kCount = 30;
  constexpr int kRuns = 300;
  const AlignmentPairs<Space> exact = TestFixture::exact_pairs(kCount);
  RandomStream random(1, 0);
  AlignmentOptions options;
  options.gate_probability = 1.0 - 1e-9;  // the gate's own bias is tested elsewhere
  double nees = 0.0;
  double joint_nees = 0.0;
  double residual = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const auto result = align_frames<Space>(TestFixture::noisy_pairs(kCount, &random), options);
    ASSERT_TRUE(result.alignment) << result.refusal;
    const Alignment<Space>& alignment = *result.alignment;
    ASSERT_TRUE(IsCovariance(alignment.covariance, 1e-9));
    const auto error = pose_error<Space>(alignment.global_from_local.map_from_base, TestFixture::transform());
    nees += error.dot(alignment.global_from_local.covariance.llt().solve(error));
    Eigen::VectorXd all(alignment.covariance.rows());
    all << error, exact.local_points - alignment.local_points;
    joint_nees += all.dot(alignment.covariance.llt().solve(all));
    residual += alignment.squared_distance;
    EXPECT_EQ(alignment.dof, Space::kPointDim * kCount - Space::kPoseDim);
  }
  const auto expect_chi_square = [&](double sum, int dof) {
    EXPECT_GT(sum, chi_square_quantile(0.001, dof * kRuns));
    EXPECT_LT(sum, chi_square_quantile(0.999, dof * kRuns));
  };
  expect_chi_square(nees, Space::kPoseDim);
  expect_chi_square(joint_nees, Space::kPoseDim + Space::kPointDim * kCount);
  expect_chi_square(residual, Space::kPointDim * kCount - Space::kPoseDim);
}

/// One place far off does not bend the others, and is told with both estimates.
TYPED_TEST(AlignmentOf, LeavesOutWhatDoesNotOverlap) {
  using Space = TypeParam;
  RandomStream random(2, 0);
  AlignmentPairs<Space> pairs = TestFixture::noisy_pairs(30, &random);
  pairs.in_global[12].mean(0) += 20.0;
  const auto result = align_frames<Space>(pairs, {});
  ASSERT_TRUE(result.alignment) << result.refusal;
  ASSERT_EQ(result.alignment->disagreements.size(), 1U);
  const Disagreement<Space>& disagreement = result.alignment->disagreements.front();
  EXPECT_EQ(disagreement.pair, 12U);
  EXPECT_TRUE(MatrixNear(disagreement.by_global_position.mean, pairs.in_global[12].mean, 0.0));
  EXPECT_TRUE(
      MatrixNear(disagreement.by_path.mean, TestFixture::transform() * TestFixture::places(30)[12], 0.5));
  const auto error =
      pose_error<Space>(result.alignment->global_from_local.map_from_base, TestFixture::transform());
  EXPECT_LT(error.norm(), 0.5);
}

TYPED_TEST(AlignmentOf, RefusesTooFew) {
  const auto result = align_frames<TypeParam>(TestFixture::exact_pairs(1), {});
  EXPECT_FALSE(result.alignment);
  EXPECT_NE(result.refusal.find("1 of 1 global positions agree"), std::string::npos) << result.refusal;
}

TYPED_TEST(AlignmentOf, RefusesWhenMostDisagree) {
  using Space = TypeParam;
  AlignmentPairs<Space> pairs = TestFixture::exact_pairs(12);
  for (std::size_t i = 0; i < 12; ++i) pairs.in_global[i].mean(0) += (i * i * 7) % 23;
  EXPECT_FALSE(align_frames<Space>(pairs, {}).alignment);
}

/// A robot that stands: in the plane it is the heading that nothing tells.
TYPED_TEST(AlignmentOf, SaysWhatARobotThatStandsLacks) {
  AlignmentPairs<TypeParam> pairs = TestFixture::exact_pairs(20);
  pairs.local_points.setZero();
  for (auto& place : pairs.in_global) place.mean = TestFixture::transform().translation();
  const auto result = align_frames<TypeParam>(pairs, {});
  ASSERT_FALSE(result.alignment);
  const bool is_plane = TypeParam::kPointDim == 2;
  EXPECT_EQ(result.refusal.find("near to one place that the heading is") != std::string::npos, is_plane)
      << result.refusal;
  EXPECT_EQ(result.refusal.find("near to one line") != std::string::npos, !is_plane) << result.refusal;
}

/// In space the turn about the line is open; a heading says it. In the plane a line is enough.
TYPED_TEST(AlignmentOf, RefusesALineInSpaceUnlessAHeadingIsGiven) {
  using Space = TypeParam;
  AlignmentPairs<Space> pairs = TestFixture::exact_pairs(20, 1e-3);
  const auto without = align_frames<Space>(pairs, {});
  EXPECT_EQ(without.alignment.has_value(), Space::kPointDim == 2);
  EXPECT_EQ(without.refusal.find("line") != std::string::npos, Space::kPointDim == 3) << without.refusal;

  HeadingPrior<Space> heading;
  heading.global_from_local = TestFixture::transform();
  heading.covariance *= radians(3.0) * radians(3.0);
  const auto with = align_frames<Space>(pairs, {}, heading);
  ASSERT_TRUE(with.alignment) << with.refusal;
  EXPECT_TRUE(PoseNear(with.alignment->global_from_local.map_from_base, TestFixture::transform(), 1e-6));
  const double turn_variance = with.alignment->global_from_local.covariance.diagonal().maxCoeff();
  EXPECT_LT(turn_variance, 2.0);  // m^2: the arm of 13 m, turned by 3 deg
}

}  // namespace
}  // namespace kinect_ekf_slam
