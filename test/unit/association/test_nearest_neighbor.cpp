#include "kinect_ekf_slam/association/nearest_neighbor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "test/support/fake_map.h"

namespace kinect_ekf_slam {
namespace {

using testing::FakeMap;
using testing::sighting;

constexpr double kVariance = 0.005;  // m^2, of an innovation: 5 cm of the landmark, 5 cm of the sighting

double distance_of(double probability) { return std::sqrt(chi_square_quantile(probability, 2) * kVariance); }

std::vector<Assignment> associate(const std::vector<Observation<Planar>>& observations, const FakeMap& map,
                                  const AssociationOptions& options = {}) {
  return NearestNeighbor<Planar>(options).associate(observations, map);
}

TEST(NearestNeighbor, MakesLandmarksOfAllInAnEmptyMap) {
  for (const Assignment& assignment : associate({sighting({1.0, 0.0}), sighting({1.0, 0.5})}, FakeMap())) {
    EXPECT_EQ(assignment.verdict, Verdict::kCreated);
    EXPECT_EQ(assignment.landmark, -1);
  }
}

TEST(NearestNeighbor, MakesOneLandmarkOfAnObjectThatIsSeenTwiceAtOnce) {
  const auto assignments = associate(
      {sighting({1.01, 0.0}), sighting({1.0, 0.0}), sighting({1.02, 0.0}), sighting({3.0, 0.0})}, FakeMap());
  EXPECT_EQ(assignments[0].verdict, Verdict::kDuplicateIdentity);
  EXPECT_EQ(assignments[1].verdict, Verdict::kCreated) << "the nearest";
  EXPECT_EQ(assignments[2].verdict, Verdict::kDuplicateIdentity);
  EXPECT_EQ(assignments[3].verdict, Verdict::kCreated);
}

TEST(NearestNeighbor, TakesTheNearest) {
  const FakeMap map = FakeMap().add({1.0, 0.0}).add({1.15, 0.0}).add({1.0, 3.0});
  const Assignment assignment = associate({sighting({1.09, 0.0})}, map)[0];
  EXPECT_EQ(assignment.verdict, Verdict::kMatched);
  EXPECT_EQ(assignment.landmark, 1);
  EXPECT_NEAR(assignment.squared_distance, 0.06 * 0.06 / kVariance, 1e-9);
}

TEST(NearestNeighbor, MeasuresDistanceInSigmasNotInMetres) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.01).add({1.5, 0.0}, 0.3);
  EXPECT_EQ(associate({sighting({1.2, 0.0})}, map)[0].landmark, 1);
}

TEST(NearestNeighbor, IgnoresTheIdentityThatADetectorRead) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.05, 7).add({2.0, 0.0}, 0.05, 8);
  EXPECT_EQ(associate({sighting({1.0, 0.0}, 8)}, map)[0].landmark, 0);
}

TEST(NearestNeighbor, LeavesTheZoneBetweenTheGatesAlone) {
  const FakeMap map = FakeMap().add({1.0, 0.0});
  const auto verdict_at = [&](double distance) {
    return associate({sighting({1.0 + distance, 0.0})}, map)[0].verdict;
  };
  EXPECT_EQ(verdict_at(0.999 * distance_of(0.975)), Verdict::kMatched);
  EXPECT_EQ(verdict_at(1.001 * distance_of(0.975)), Verdict::kAmbiguous);
  EXPECT_EQ(verdict_at(0.999 * distance_of(0.99999)), Verdict::kAmbiguous);
  EXPECT_EQ(verdict_at(1.001 * distance_of(0.99999)), Verdict::kCreated);
}

TEST(NearestNeighbor, MakesNoLandmarkWithinTheDistanceOfAnother) {
  AssociationOptions options;
  options.new_landmark_distance = 0.5;
  const FakeMap map = FakeMap().add({1.0, 0.0});
  EXPECT_EQ(associate({sighting({1.49, 0.0})}, map, options)[0].verdict, Verdict::kAmbiguous);
  EXPECT_EQ(associate({sighting({1.51, 0.0})}, map, options)[0].verdict, Verdict::kCreated);
}

TEST(NearestNeighbor, AnAmbiguousSightingNamesTheNearestLandmark) {
  const double zone = 1.1 * distance_of(0.975);
  const FakeMap map = FakeMap().add({1.0, 0.0}).add({1.0 + 2.1 * zone, 0.0});
  const Assignment assignment =
      associate({sighting({1.0 + 1.1 * zone, 0.0})}, map)[0];  // nearer to the second
  EXPECT_EQ(assignment.verdict, Verdict::kAmbiguous);
  EXPECT_EQ(assignment.landmark, 1);
  EXPECT_NEAR(assignment.squared_distance, zone * zone / kVariance, 1e-9);
}

TEST(NearestNeighbor, PairsOneToOne) {
  const FakeMap map = FakeMap().add({1.0, 0.0});
  const auto assignments = associate({sighting({1.05, 0.0}), sighting({1.01, 0.0})}, map);
  EXPECT_EQ(assignments[0].verdict, Verdict::kDuplicateIdentity);
  EXPECT_EQ(assignments[0].landmark, 0);
  EXPECT_EQ(assignments[1].verdict, Verdict::kMatched);
}

TEST(NearestNeighbor, ASightingThatLosesItsLandmarkMayHaveTheNext) {
  const FakeMap map = FakeMap().add({1.0, 0.0}).add({1.1, 0.0});
  const auto assignments = associate({sighting({1.03, 0.0}), sighting({1.0, 0.0})}, map);
  EXPECT_EQ(assignments[0].landmark, 1);
  EXPECT_EQ(assignments[0].verdict, Verdict::kMatched);
  EXPECT_EQ(assignments[1].landmark, 0);
}

TEST(NearestNeighbor, RefusesASingularInnovationCovariance) {
  FakeMap map = FakeMap().add({1.0, 0.0});
  map.set_covariance(0, -Eigen::Matrix2d::Identity());
  EXPECT_EQ(associate({sighting({1.0, 0.0})}, map)[0].verdict, Verdict::kSingular);
}

/// Landmarks all round the robot, behind it and on both sides of +-180 degrees, are found again.
TEST(NearestNeighbor, FindsALandmarkAgainAtAnyBearing) {
  FakeMap map;
  const int count = 36;
  const auto at = [](double bearing) {
    return Eigen::Vector2d(2.0 * std::cos(bearing), 2.0 * std::sin(bearing));
  };
  for (int i = 0; i < count; ++i) map.add(at(radians(10.0 * i)));
  for (int i = 0; i < count; ++i) {
    for (const double offset : {-2.0, 0.0, 2.0}) {  // deg, 7 cm
      const Assignment assignment = associate({sighting(at(radians(10.0 * i + offset)))}, map)[0];
      EXPECT_EQ(assignment.verdict, Verdict::kMatched) << 10 * i + offset << " deg";
      EXPECT_EQ(assignment.landmark, i) << 10 * i + offset << " deg";
    }
  }
}

TEST(NearestNeighbor, DoesNotDependOnTheOrderOfSightingsOrLandmarks) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(-0.6, 0.6);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Eigen::Vector2d> landmarks;
    std::vector<Observation<Planar>> sightings;
    for (int i = 0; i < 8; ++i) landmarks.emplace_back(place(random), place(random));
    for (int i = 0; i < 8; ++i) sightings.push_back(sighting({place(random), place(random)}));
    std::vector<int> landmark_order(8);
    std::vector<std::size_t> sighting_order(8);
    std::iota(landmark_order.begin(), landmark_order.end(), 0);
    std::iota(sighting_order.begin(), sighting_order.end(), 0U);
    std::shuffle(landmark_order.begin(), landmark_order.end(), random);
    std::shuffle(sighting_order.begin(), sighting_order.end(), random);

    FakeMap map;
    FakeMap shuffled_map;
    std::vector<Observation<Planar>> shuffled;
    for (const Eigen::Vector2d& landmark : landmarks) map.add(landmark);
    for (const int index : landmark_order) shuffled_map.add(landmarks[index]);
    for (const std::size_t index : sighting_order) shuffled.push_back(sightings[index]);

    const auto expected = associate(sightings, map);
    const auto found = associate(shuffled, shuffled_map);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Assignment& original = expected[sighting_order[i]];
      EXPECT_EQ(found[i].verdict, original.verdict) << "trial " << trial;
      const int landmark = found[i].landmark < 0 ? -1 : landmark_order[found[i].landmark];
      EXPECT_EQ(landmark, original.landmark) << "trial " << trial;
    }
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
