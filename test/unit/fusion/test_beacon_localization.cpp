#include "kinect_ekf_slam/fusion/beacon_localization.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

template <class Space>
class BeaconLocalizationIn : public ::testing::Test {
 protected:
  static constexpr int kDim = Space::kPointDim;
  using Point = typename Space::Point;
  using Position = Gaussian<kDim>;

  static std::map<int, Position> beacons() {
    std::map<int, Position> beacons;
    int id = 0;
    for (const Eigen::Vector3d& place :
         {Eigen::Vector3d(0, 0, 9), Eigen::Vector3d(40, 0, -9), Eigen::Vector3d(0, 40, -9),
          Eigen::Vector3d(40, 40, 9), Eigen::Vector3d(20, -20, 0)}) {
      beacons[id++] = {Space::from_3d(place), 1e-6 * Space::PointMatrix::Identity()};
    }
    return beacons;
  }
  static std::vector<BeaconRange> ranges_from(const Point& place, double sigma, RandomStream* random) {
    std::vector<BeaconRange> ranges;
    for (const auto& [id, beacon] : beacons()) {
      const double noise = random == nullptr ? 0.0 : sigma * random->normal();
      ranges.push_back({id, (beacon.mean - place).norm() + noise, sigma * sigma});
    }
    return ranges;
  }
  static Position near(const Point& place, double sigma) {
    return {place, sigma * sigma * Space::PointMatrix::Identity()};
  }
  template <class Normal>
  static Point random_point(const Normal& normal) {
    return Point::NullaryExpr(normal);
  }
};
TYPED_TEST_SUITE(BeaconLocalizationIn, testing::Spaces, testing::SpaceNames);

TYPED_TEST(BeaconLocalizationIn, FindsThePlaceFromExactRanges) {
  const auto place = TypeParam::from_3d(Eigen::Vector3d(12.0, 17.0, 2.0));
  BeaconLocalization<TypeParam> robot(TestFixture::beacons(), {}, 0,
                                      TestFixture::near(place + TypeParam::Point::Constant(2.0), 3.0));
  const auto report = robot.update(0, TestFixture::ranges_from(place, 0.3, nullptr));
  ASSERT_TRUE(report.fix);
  EXPECT_TRUE(MatrixNear(report.fix->mean, place, 1e-6));
  EXPECT_EQ(report.refused + report.unknown, 0);
}

/// Closed form: the covariance of a fix is (sum u u^T / sigma^2)^-1, u the directions to the beacons.
TYPED_TEST(BeaconLocalizationIn, KnowsHowSureAFixIs) {
  const auto place = TypeParam::from_3d(Eigen::Vector3d(12.0, 17.0, 2.0));
  typename TypeParam::PointMatrix information = TypeParam::PointMatrix::Zero();
  for (const auto& [id, beacon] : TestFixture::beacons()) {
    const typename TypeParam::Point direction = (beacon.mean - place).normalized();
    information += direction * direction.transpose() / (0.3 * 0.3 + 1e-6);
  }
  BeaconLocalization<TypeParam> robot(TestFixture::beacons(), {}, 0, TestFixture::near(place, 1.0));
  const auto report = robot.update(0, TestFixture::ranges_from(place, 0.3, nullptr));
  ASSERT_TRUE(report.fix);
  EXPECT_TRUE(MatrixNear(report.fix->covariance, information.inverse(), 1e-6));
}

/// NEES of filter and fixes on many runs of what the filter assumes; and fixes of different times are
/// independent.
TYPED_TEST(BeaconLocalizationIn, KnowsItsErrors) {
  using Space = TypeParam;
  constexpr int kRuns = 200;
  constexpr double kSigma = 0.3;
  BeaconLocalizationOptions options;
  options.gate_probability = 1.0 - 1e-9;
  double filter_nees = 0.0;
  double fix_nees = 0.0;
  double pair_nees = 0.0;
  int without_fix = 0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(run, 0);
    const auto normal = [&] { return random.normal(); };
    typename Space::Point place = Space::from_3d(Eigen::Vector3d(15.0, 15.0, 0.0));
    typename Space::Point velocity = 0.3 * TestFixture::random_point(normal);
    const typename Space::Point start = place + TestFixture::random_point(normal);
    BeaconLocalization<Space> robot(TestFixture::beacons(), options, 0, TestFixture::near(start, 1.0));
    typename Space::Point last = Space::Point::Zero();
    for (int step = 1; step <= 20; ++step) {
      const int kParts = 20;
      for (int part = 0; part < kParts; ++part) {  // a white acceleration
        velocity += options.acceleration_noise * std::sqrt(1.0 / kParts) * TestFixture::random_point(normal);
        place += velocity / kParts;
      }
      const auto report =
          robot.update(to_nanoseconds(step), TestFixture::ranges_from(place, kSigma, &random));
      if (!report.fix) {  // beside a beacon least squares does not settle
        ++without_fix;
        continue;
      }
      const typename Space::Point error = report.fix->mean - place;
      const auto root = report.fix->covariance.llt();
      const typename Space::Point whitened = root.matrixL().solve(error);
      if (step == 20) {
        fix_nees += whitened.squaredNorm();
        pair_nees += (whitened + last).squaredNorm() / 2.0;
        const typename Space::Point off = robot.position().mean - place;
        filter_nees += off.dot(robot.position().covariance.llt().solve(off));
      }
      last = whitened;
    }
  }
  EXPECT_LE(without_fix, kRuns * 20 / 200);
  for (const double nees : {filter_nees, fix_nees, pair_nees}) {
    EXPECT_GT(nees, chi_square_quantile(0.001, Space::kPointDim * kRuns));
    EXPECT_LT(nees, chi_square_quantile(0.999, Space::kPointDim * kRuns));
  }
}

TYPED_TEST(BeaconLocalizationIn, RefusesARangeThatCannotBeAndCountsUnknownBeacons) {
  const auto place = TypeParam::from_3d(Eigen::Vector3d(12.0, 17.0, 2.0));
  BeaconLocalization<TypeParam> robot(TestFixture::beacons(), {}, 0, TestFixture::near(place, 0.5));
  auto ranges = TestFixture::ranges_from(place, 0.3, nullptr);
  ranges[2].range += 30.0;
  ranges.push_back({99, 5.0, 0.1});
  const auto report = robot.update(0, ranges);
  EXPECT_EQ(report.refused, 1);
  EXPECT_EQ(report.unknown, 1);
  EXPECT_TRUE(MatrixNear(robot.position().mean, place, 1e-3));
  ASSERT_TRUE(report.fix);
  EXPECT_TRUE(MatrixNear(report.fix->mean, place, 1e-6));
}

TYPED_TEST(BeaconLocalizationIn, TooFewBeaconsGiveNoFixButStillHelpTheFilter) {
  const auto place = TypeParam::from_3d(Eigen::Vector3d(12.0, 17.0, 2.0));
  BeaconLocalization<TypeParam> robot(TestFixture::beacons(), {}, 0, TestFixture::near(place, 2.0));
  auto ranges = TestFixture::ranges_from(place, 0.3, nullptr);
  ranges.resize(1);
  const double before = robot.position().covariance.trace();
  EXPECT_FALSE(robot.update(0, ranges).fix);
  EXPECT_LT(robot.position().covariance.trace(), before);
}

}  // namespace
}  // namespace kinect_ekf_slam
