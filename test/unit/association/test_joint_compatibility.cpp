#include "kinect_ekf_slam/association/joint_compatibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "kinect_ekf_slam/association/nearest_neighbor.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "test/support/joint_case.h"

namespace kinect_ekf_slam {
namespace {

using testing::FakeMap;
using testing::JointCase;
using testing::random_joint_case;
using testing::sighting;

constexpr double kGateProbability = 0.975;

std::vector<Assignment> associate_jointly(const std::vector<Observation<Planar>>& observations,
                                          const PredictedMap<Planar>& map,
                                          const AssociationOptions& options = {}) {
  return JointCompatibility<Planar>(options).associate(observations, map);
}

/// Of each sighting, -1: of none.
std::vector<int> landmarks_of(const std::vector<Assignment>& assignments) {
  std::vector<int> landmarks;
  for (const Assignment& assignment : assignments) {
    landmarks.push_back(assignment.verdict == Verdict::kMatched ? assignment.landmark : -1);
  }
  return landmarks;
}

int count_pairs(const std::vector<int>& landmarks) {
  return static_cast<int>(
      std::count_if(landmarks.begin(), landmarks.end(), [](int landmark) { return landmark >= 0; }));
}

/// Tries every way to pair; as sightings are taken one by one, each beginning must be compatible as well.
void try_all(const JointCase& drawn, std::vector<int>* landmarks, std::vector<int>* best) {
  const int count = count_pairs(*landmarks);
  const double distance = drawn.squared_distance(*landmarks);
  if (count > 0 && !(distance < chi_square_quantile(kGateProbability, 2 * count))) return;
  if (landmarks->size() == drawn.sightings.size()) {
    const int best_count = best->empty() ? -1 : count_pairs(*best);
    if (count > best_count || (count == best_count && distance < drawn.squared_distance(*best))) {
      *best = *landmarks;
    }
    return;
  }
  const std::vector<int> alone(landmarks->size(), -1);
  for (int landmark = -1; landmark < drawn.map.size(); ++landmark) {
    if (landmark >= 0) {
      if (std::count(landmarks->begin(), landmarks->end(), landmark) > 0) continue;
      std::vector<int> pair = alone;
      pair.push_back(landmark);
      if (!(drawn.squared_distance(pair) < chi_square_quantile(kGateProbability, 2))) continue;
    }
    landmarks->push_back(landmark);
    try_all(drawn, landmarks, best);
    landmarks->pop_back();
  }
}

TEST(JointCompatibility, FindsWhatTryingAllPairingsFinds) {
  std::mt19937_64 random(4);
  AssociationOptions options;
  options.joint_work = 1000000;
  int other_than_nearest = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const JointCase drawn = random_joint_case(&random, 5, 4, 1.0);
    std::vector<int> none;
    std::vector<int> expected;
    try_all(drawn, &none, &expected);
    EXPECT_EQ(landmarks_of(associate_jointly(drawn.sightings, drawn.map, options)), expected)
        << "trial " << trial;
    const auto nearest = NearestNeighbor<Planar>(options).associate(drawn.sightings, drawn.map);
    if (landmarks_of(nearest) != expected) ++other_than_nearest;
  }
  EXPECT_GT(other_than_nearest, 20) << "the cases are hard enough to tell";
}

/// A row of like landmarks, and a robot that is turned by more than half the way from one to the next.
TEST(JointCompatibility, SeesThroughATurnThatMisleadsTheNearestNeighbour) {
  const double turn = 0.1;  // rad: 0.3 m at 3 m, landmarks are 0.5 m apart
  FakeMap map;
  std::vector<Observation<Planar>> sightings;
  Eigen::MatrixXd by_pose(6, 3);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d point(3.0, 0.5 * (i - 1));
    map.add(point);
    sightings.push_back(sighting(Se2({0.0, 0.0}, turn) * point, kNoId, 0.02));
    by_pose.middleRows<2>(2 * i) = Planar::point_by_pose(point);
  }
  const Eigen::DiagonalMatrix<double, 3> pose_covariance(0.01, 0.01, turn * turn);
  map.set_joint_covariance(by_pose * pose_covariance * by_pose.transpose() +
                           1e-4 * Eigen::MatrixXd::Identity(6, 6));
  const auto nearest = NearestNeighbor<Planar>(AssociationOptions()).associate(sightings, map);
  EXPECT_EQ(nearest[0].landmark, 1) << "the neighbour's, or the case is too easy";
  EXPECT_EQ(landmarks_of(associate_jointly(sightings, map)), (std::vector<int>{0, 1, 2}));
}

TEST(JointCompatibility, LeavesOutTheSightingThatDoesNotAgree) {
  Eigen::MatrixXd common(4, 4);  // all move together, by some 0.3 m
  common << Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(),
      Eigen::Matrix2d::Identity();
  FakeMap map = FakeMap().add({2.0, 0.0}).add({2.0, 2.0});
  map.set_joint_covariance(0.09 * common + 1e-4 * Eigen::MatrixXd::Identity(4, 4));
  const auto assignments = associate_jointly({sighting({2.3, 0.0}), sighting({1.7, 2.0})}, map);
  EXPECT_EQ(count_pairs(landmarks_of(assignments)), 1) << "each is possible, both are not";
  for (const Assignment& assignment : assignments) EXPECT_NE(assignment.verdict, Verdict::kCreated);
}

TEST(JointCompatibility, TellsNewAndAmbiguousAsTheNearestNeighbourDoes) {
  const FakeMap map = FakeMap().add({1.0, 0.0});
  const auto assignments =
      associate_jointly({sighting({1.25, 0.0}), sighting({3.0, 0.0}), sighting({3.02, 0.0})}, map);
  EXPECT_EQ(assignments[0].verdict, Verdict::kAmbiguous);
  EXPECT_EQ(assignments[1].verdict, Verdict::kCreated);
  EXPECT_EQ(assignments[2].verdict, Verdict::kDuplicateIdentity);
}

/// Counts how often a landmark is looked up.
class CountingMap : public FakeMap {
 public:
  Eigen::Matrix2d covariance(int landmark) const override {
    ++lookups;
    return FakeMap::covariance(landmark);
  }
  mutable int lookups = 0;
};

TEST(JointCompatibility, StopsAfterItsWorkWithAPairingThatIsValid) {
  constexpr int kCount = 9;  // that many in one place: 9! pairings
  CountingMap map;
  std::vector<Observation<Planar>> sightings;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-0.03, 0.03);
  for (int i = 0; i < kCount; ++i) {
    map.add({1.0 + place(random), place(random)});
    sightings.push_back(sighting({1.0 + place(random), place(random)}));
  }
  for (const int work : {0, 100, 2000}) {
    AssociationOptions options;
    options.joint_work = work;
    map.lookups = 0;
    const std::vector<int> landmarks = landmarks_of(associate_jointly(sightings, map, options));
    EXPECT_LE(map.lookups, kCount + std::max(work, kCount)) << "gates, then pairings";
    EXPECT_EQ(std::set<int>(landmarks.begin(), landmarks.end()).size(), std::size_t{kCount}) << "one to one";
    EXPECT_EQ(count_pairs(landmarks), kCount);
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
