#include "kinect_ekf_slam/association/known_identity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "kinect_ekf_slam/core/chi_square.h"
#include "test/support/fake_map.h"

namespace kinect_ekf_slam {
namespace {

using testing::FakeMap;
using testing::sighting;

// Landmark and sighting have 5 cm each: innovations have a variance of 0.005 m^2 in each axis.
constexpr double kSightingVariance = 0.005;

std::vector<Assignment> identify(const std::vector<Observation<Planar>>& observations, const FakeMap& map,
                                 double gate_probability = 0.975) {
  AssociationOptions options;
  options.gate_probability = gate_probability;
  return KnownIdentity<Planar>(options).associate(observations, map);
}

TEST(KnownIdentity, MatchesByIdentityAndNotByPlace) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7).add({1.1, 0.0}, 0.05, 8);
  const auto assignments = identify({sighting({1.02, 0.0}, 8)}, map);
  EXPECT_EQ(assignments[0].verdict, Verdict::kMatched);
  EXPECT_EQ(assignments[0].landmark, 1);
  EXPECT_NEAR(assignments[0].squared_distance, 0.08 * 0.08 / kSightingVariance, 1e-9);
}

TEST(KnownIdentity, HasAGate) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7);
  const double edge = std::sqrt(chi_square_quantile(0.975, 2) * kSightingVariance);
  EXPECT_EQ(identify({sighting({1.0, 0.999 * edge}, 7)}, map)[0].verdict, Verdict::kMatched);
  const Assignment outside = identify({sighting({1.0, 1.001 * edge}, 7)}, map)[0];
  EXPECT_EQ(outside.verdict, Verdict::kOutsideGate);
  EXPECT_EQ(outside.landmark, 0);
  EXPECT_NEAR(outside.squared_distance, 1.001 * 1.001 * 7.378, 1e-2);
  EXPECT_EQ(identify({sighting({1.0, 1.001 * edge}, 7)}, map, 0.99)[0].verdict, Verdict::kMatched);
}

TEST(KnownIdentity, ANewIdentityIsANewLandmark) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7);
  const Assignment assignment = identify({sighting({1.0, 0.0}, 9)}, map)[0];
  EXPECT_EQ(assignment.verdict, Verdict::kCreated);
  EXPECT_EQ(assignment.landmark, -1);
}

TEST(KnownIdentity, WithoutIdentityThereIsNoMatch) {
  // A landmark of a map made by other means has no identity either: the two are not the same for that.
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, kNoId);
  EXPECT_EQ(identify({sighting({1.0, 0.0}, kNoId)}, map)[0].verdict, Verdict::kNoIdentity);
}

TEST(KnownIdentity, RefusesASingularInnovationCovariance) {
  FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7);
  Observation<Planar> flat = sighting({1.0, 0.0}, 7);
  flat.covariance = Eigen::Vector2d(0.01, 0.0).asDiagonal();
  map.set_covariance(0, Eigen::Matrix2d::Zero());
  EXPECT_EQ(identify({flat}, map)[0].verdict, Verdict::kSingular);
  map.set_covariance(0, -Eigen::Matrix2d::Identity());
  EXPECT_EQ(identify({flat}, map)[0].verdict, Verdict::kSingular);
  map.set_covariance(0, std::numeric_limits<double>::quiet_NaN() * Eigen::Matrix2d::Identity());
  EXPECT_EQ(identify({flat}, map)[0].verdict, Verdict::kSingular);
}

/// The verdict of each observation is the same whatever order they come in.
void expect_whatever_the_order(const std::vector<Observation<Planar>>& observations, const FakeMap& map,
                               const std::vector<Verdict>& expected) {
  std::vector<std::size_t> order(observations.size());
  std::iota(order.begin(), order.end(), 0U);
  do {
    std::vector<Observation<Planar>> permuted;
    for (const std::size_t index : order) permuted.push_back(observations[index]);
    const auto assignments = identify(permuted, map);
    for (std::size_t i = 0; i < order.size(); ++i) {
      EXPECT_STREQ(to_string(assignments[i].verdict), to_string(expected[order[i]]))
          << "observation " << order[i];
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(KnownIdentity, KeepsTheBestOfSeveralSightingsOfOneLandmark) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7).add({3.0, 0.0}, 0.05, 8);
  expect_whatever_the_order(
      {sighting({1.10, 0.0}, 7), sighting({1.01, 0.0}, 7), sighting({3.0, 0.0}, 8), sighting({1.0, 0.05}, 7)},
      map, {Verdict::kDuplicateIdentity, Verdict::kMatched, Verdict::kMatched, Verdict::kDuplicateIdentity});
}

TEST(KnownIdentity, ASightingOutsideTheGateDoesNotTakeThePlaceOfAGoodOne) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7);
  expect_whatever_the_order({sighting({2.0, 0.0}, 7), sighting({1.1, 0.0}, 7)}, map,
                            {Verdict::kOutsideGate, Verdict::kMatched});
}

TEST(KnownIdentity, KeepsTheNearerOfTwoSightingsOfANewLandmark) {
  expect_whatever_the_order({sighting({2.0, 0.0}, 7), sighting({1.0, 0.5}, 7), sighting({2.5, 0.0}, 7)},
                            FakeMap(),
                            {Verdict::kDuplicateIdentity, Verdict::kCreated, Verdict::kDuplicateIdentity});
}

}  // namespace
}  // namespace kinect_ekf_slam
