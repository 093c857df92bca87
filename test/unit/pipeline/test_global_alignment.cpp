#include "kinect_ekf_slam/pipeline/global_alignment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kSigma = 0.5;  // m

template <class Space>
class GlobalAlignments : public ::testing::Test {
 protected:
  using Pair = typename GlobalAlignment<Space>::Pair;

  /// The map is turned and shifted in the global frame; the robot drives (or climbs) an arc of 12 m.
  Pair pair(double way) {
    const Eigen::Vector3d in_map(10.0 * std::sin(0.1 * way), 10.0 - 10.0 * std::cos(0.1 * way), 0.2 * way);
    Pair pair;
    pair.antenna_in_map = Space::from_3d(in_map);
    pair.position = Space::from_3d(Eigen::Vector3d(global_from_map() * in_map));
    for (double& number : pair.position) number += kSigma * random_.normal();
    pair.position_covariance = kSigma * kSigma * Space::PointMatrix::Identity();
    return pair;
  }
  static Eigen::Isometry3d global_from_map() {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(4e5, -3e4, Space::kPointDim == 3 ? 120.0 : 0.0);
    pose.linear() = Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return pose;
  }
  RandomStream random_{1, 0};
};
TYPED_TEST_SUITE(GlobalAlignments, testing::Spaces, testing::SpaceNames);

TYPED_TEST(GlobalAlignments, AreAsSureAsTheyMayBe) {
  using Space = TypeParam;
  constexpr int kUnknowns = Space::kPointDim + 1;
  constexpr int kRuns = 100;
  double nees = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    GlobalAlignment<Space> alignment;
    for (double way = 0.0; way < 12.0; way += 0.5) alignment.add(this->pair(way));
    const auto solution = alignment.solve();
    if (!solution) continue;  // one in a thousand looks too bad
    // What is left to do: a small shift, and a turn about the map's origin.
    const Eigen::Isometry3d left = (solution->map_from_global * this->global_from_map()).inverse();
    Eigen::Matrix<double, kUnknowns, 1> error;
    error << Space::from_3d(Eigen::Vector3d(left.translation())), std::atan2(left(1, 0), left(0, 0));
    Eigen::Matrix<double, kUnknowns, kUnknowns> covariance;
    const auto place = [](int i) { return i < Space::kPointDim ? i : Space::kPoseDim - 1; };
    for (int i = 0; i < kUnknowns; ++i) {
      for (int j = 0; j < kUnknowns; ++j) covariance(i, j) = solution->covariance(place(i), place(j));
    }
    nees += error.dot(covariance.llt().solve(error));
    EXPECT_DOUBLE_EQ(solution->heading_sigma, std::sqrt(covariance(kUnknowns - 1, kUnknowns - 1)));
  }
  EXPECT_GT(nees, chi_square_quantile(0.001, kUnknowns * kRuns));
  EXPECT_LT(nees, chi_square_quantile(0.999, kUnknowns * kRuns));
}

TYPED_TEST(GlobalAlignments, NeedThreePositions) {
  GlobalAlignment<TypeParam> alignment;
  alignment.add(this->pair(0.0));
  alignment.add(this->pair(6.0));
  EXPECT_FALSE(alignment.solve());
}

TYPED_TEST(GlobalAlignments, AreNoneWherePositionsContradictTheWay) {
  GlobalAlignment<TypeParam> alignment;
  for (double way = 0.0; way < 12.0; way += 0.5) {
    auto pair = this->pair(way);
    pair.position *= 1.0 + 1e-4 * way;  // a scale: tens of metres, here
    alignment.add(pair);
  }
  EXPECT_FALSE(alignment.solve());
}

}  // namespace
}  // namespace kinect_ekf_slam
