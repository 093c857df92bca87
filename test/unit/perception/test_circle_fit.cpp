#include "kinect_ekf_slam/perception/circle_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;

constexpr RadiusBounds kBounds{0.03, 0.20};

/// The side of a circle that the sensor sees, within `half_arc` of the direction to it.
Outline arc(const Eigen::Vector2d& center, double radius, double half_arc, int count, double sigma) {
  Outline outline;
  const double toward_sensor = std::atan2(-center.y(), -center.x());
  for (int i = 0; i < count; ++i) {
    const double angle = toward_sensor + half_arc * (2.0 * i / (count - 1) - 1.0);
    outline.push_back(
        {center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)), sigma, 0.3 * sigma});
  }
  return outline;
}

void add_range_noise(Outline* outline, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  for (OutlinePoint& point : *outline) {
    const Eigen::Vector2d ray = point.position.normalized();
    const Eigen::Vector2d aside(-ray.y(), ray.x());
    const double along = point.sigma * normal(*random);
    point.position += along * ray + point.sigma_aside * normal(*random) * aside;
  }
}

TEST(CircleFit, IsExactWithoutNoise) {
  const Eigen::Vector2d center(2.0, 0.5);
  const auto circle = fit_circle(arc(center, 0.15, 1.3, 12, 1e-6), kBounds);
  ASSERT_TRUE(circle);
  EXPECT_TRUE(MatrixNear(circle->center, center, 1e-7));
  EXPECT_NEAR(circle->radius, 0.15, 1e-7);
}

TEST(CircleFit, IsUnbiasedAndKnowsItsError) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  constexpr int kRuns = 800;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double squared = 0.0;
  int count = 0;
  for (int run = 0; run < kRuns; ++run) {
    // Radii as the bounds say: two standard deviations on each side.
    const Eigen::Vector2d center(0.8 + uniform(random), 1.0);
    const double radius = kBounds.mean() + kBounds.sigma() * normal(random);
    if (radius < 0.04) continue;
    Outline outline = arc(center, radius, 1.2, 15, 0.003);
    add_range_noise(&outline, &random);
    const auto circle = fit_circle(outline, kBounds);
    ASSERT_TRUE(circle);
    EXPECT_TRUE(IsCovariance(circle->covariance));
    const Eigen::Vector3d error(circle->center.x() - center.x(), circle->center.y() - center.y(),
                                circle->radius - radius);
    mean += error;
    squared += error.dot(circle->covariance.ldlt().solve(error));
    ++count;
  }
  ASSERT_GT(count, 600);
  EXPECT_LT((mean / count).cwiseAbs().maxCoeff(), 0.001);
  EXPECT_NEAR(squared / count, 3.0, 0.3);
}

TEST(CircleFit, AShortArcIsUncertainAlongTheRayNotAcrossIt) {
  const auto circle = fit_circle(arc({2.0, 0.0}, 0.1, 0.4, 12, 0.005), kBounds);
  ASSERT_TRUE(circle);
  EXPECT_GT(circle->covariance(0, 0), 4.0 * circle->covariance(1, 1));
}

TEST(CircleFit, TooFewOrAlignedPointsAreNoCrash) {
  EXPECT_FALSE(fit_circle({}, kBounds));
  EXPECT_FALSE(fit_circle(arc({1.0, 0.0}, 0.1, 1.0, 2, 0.01), kBounds));
  for (const double distance : {0.2, 1.5, 3.0}) {
    Outline row;
    for (int i = 0; i < 6; ++i) row.push_back({{distance, 0.05 * i - 0.125}, 0.01, 0.003});
    const auto circle = fit_circle(row, kBounds);
    EXPECT_TRUE(!circle || circle->covariance.allFinite());
  }
}

TEST(CircleFit, BearingsCountFromTheSensorToTheLeft) {
  const Circle circle{{2.0, 0.0}, 0.1, Eigen::Matrix3d::Identity(), 0.0};
  EXPECT_NEAR(circle.bearing({1.9, 0.0}), 0.0, 1e-12);
  EXPECT_NEAR(circle.bearing({2.0, 0.1}), 0.5 * kPi, 1e-12);
  EXPECT_NEAR(circle.bearing({2.0, -0.1}), -0.5 * kPi, 1e-12);
}

TEST(CornerFit, ExplainsCornersAndCirclesFitRoundThings) {
  std::mt19937_64 random(7);
  for (int run = 0; run < 50; ++run) {
    Outline round = arc({1.5, 0.2}, 0.06, 1.1, 20, 0.002);
    add_range_noise(&round, &random);
    Outline corner;
    for (int i = -10; i <= 10; ++i) {
      corner.push_back({{1.5 + 0.006 * std::abs(i), 0.2 + 0.008 * i}, 0.002, 0.001});
    }
    add_range_noise(&corner, &random);
    const auto through_round = fit_circle(round, kBounds);
    const auto through_corner = fit_circle(corner, kBounds);
    ASSERT_TRUE(through_round && through_corner);
    EXPECT_LT(through_round->chi_square, corner_chi_square(round));
    EXPECT_GT(through_corner->chi_square, corner_chi_square(corner));
  }
  EXPECT_EQ(corner_chi_square(arc({1.0, 0.0}, 0.1, 1.0, 5, 0.01)), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace kinect_ekf_slam
