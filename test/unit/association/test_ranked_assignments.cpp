#include "kinect_ekf_slam/association/ranked_assignments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/joint_case.h"

namespace kinect_ekf_slam {
namespace {

using testing::FakeMap;
using testing::random_joint_case;
using testing::sighting;

std::vector<RankedAssignment> rank(const std::vector<Observation<Planar>>& observations, const FakeMap& map,
                                   const AssociationOptions& options = {}, bool may_add = true) {
  return AssignmentRanking<Planar>(options).rank(observations, map, may_add);
}

/// Nothing is too unlikely to be told.
AssociationOptions all_of_them() {
  AssociationOptions options;
  options.branch_width = options.clutter_width = 1e9;
  options.max_hypotheses = 100000;
  return options;
}

bool has(const std::vector<RankedAssignment>& ranking, Verdict verdict) {
  return std::any_of(ranking.begin(), ranking.end(), [&](const RankedAssignment& ranked) {
    return std::any_of(ranked.assignments.begin(), ranked.assignments.end(),
                       [&](const Assignment& assignment) { return assignment.verdict == verdict; });
  });
}

TEST(AssignmentRanking, OfNoSightingThereIsOneExplanation) {
  const auto ranking = rank({}, FakeMap().add({1.0, 0.0}));
  ASSERT_EQ(ranking.size(), 1U);
  EXPECT_EQ(ranking[0].log_ratio, 0.0);
}

TEST(AssignmentRanking, ScoresOneSightingByItsDensities) {
  AssociationOptions options = all_of_them();
  options.clutter_density = 0.002;
  options.new_landmark_density = 0.03;
  FakeMap map = FakeMap().add({1.0, 0.0}, 0.3).add({1.5, 0.0}, 0.1);
  const auto ranking = rank({sighting({1.25, 0.0}, kNoId, 0.04)}, map, options);
  ASSERT_EQ(ranking.size(), 4U);  // one landmark, the other, a new one, clutter
  const auto density = [](double distance, double variance) {
    return std::exp(-0.5 * distance * distance / variance) / (2.0 * kPi * variance);
  };
  for (const RankedAssignment& ranked : ranking) {
    const Assignment& assignment = ranked.assignments[0];
    double expected = 0.002;
    if (assignment.verdict == Verdict::kCreated) expected = 0.03;
    if (assignment.verdict == Verdict::kMatched) {
      expected = density(0.25, 0.0016 + (assignment.landmark == 0 ? 0.09 : 0.01));
    }
    EXPECT_NEAR(ranked.log_ratio, std::log(expected / 0.002), 1e-9) << to_string(assignment.verdict);
    EXPECT_EQ(ranked.log_ratio, ranked.log_ratios[0]);
  }
}

TEST(AssignmentRanking, AMisreadLabelCostsHalfItsSquaredDistance) {
  FakeMap map = FakeMap().add({1.0, 0.0});
  map.known_of(0).label_votes["red"] = 3;
  Observation<Planar> seen = sighting({1.0, 0.0});
  const double without = rank({seen}, map)[0].log_ratio;
  seen.signature.label = "blue";
  EXPECT_NEAR(rank({seen}, map)[0].log_ratio, without - std::log(19.0), 1e-9);
}

TEST(AssignmentRanking, TellsTheLikeliestFirstAndUsesNoLandmarkTwice) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const auto drawn = random_joint_case(&random, 5, 4, 0.8);
    const auto ranking = rank(drawn.sightings, drawn.map, all_of_them());
    ASSERT_GT(ranking.size(), 10U) << "trial " << trial;
    for (std::size_t i = 0; i < ranking.size(); ++i) {
      EXPECT_LE(ranking[i].log_ratio, ranking[i == 0 ? 0 : i - 1].log_ratio);
      double sum = 0.0;
      for (const double log_ratio : ranking[i].log_ratios) sum += log_ratio;
      EXPECT_NEAR(ranking[i].log_ratio, sum, 1e-9);
      std::set<int> used;
      for (const Assignment& assignment : ranking[i].assignments) {
        if (assignment.verdict != Verdict::kMatched) continue;
        EXPECT_TRUE(used.insert(assignment.landmark).second) << "trial " << trial;
      }
    }
  }
}

/// The score of pairings is their joint density: what errs together is not counted twice.
TEST(AssignmentRanking, TakesPairsTogetherByTheirJointDensity) {
  std::mt19937_64 random(7);
  const auto drawn = random_joint_case(&random, 3, 3, 0.8);
  AssociationOptions options = all_of_them();
  options.gate_probability = 0.999999;
  int checked = 0;
  for (const RankedAssignment& ranked : rank(drawn.sightings, drawn.map, options)) {
    std::vector<int> landmarks;
    for (const Assignment& assignment : ranked.assignments) landmarks.push_back(assignment.landmark);
    if (std::count(landmarks.begin(), landmarks.end(), -1) > 0) continue;
    const double log_det = std::log((2.0 * kPi * drawn.innovation_covariance(landmarks)).determinant());
    const double log_density = -0.5 * (drawn.squared_distance(landmarks) + log_det);
    EXPECT_NEAR(ranked.log_ratio, log_density - 3.0 * std::log(options.clutter_density), 1e-6);
    ++checked;
  }
  EXPECT_GT(checked, 0);
}

TEST(AssignmentRanking, CreatesNothingWhereNoneMayBeAdded) {
  const std::vector<Observation<Planar>> sightings = {sighting({1.0, 0.0}), sighting({2.0, 0.0})};
  EXPECT_TRUE(has(rank(sightings, FakeMap()), Verdict::kCreated));
  const auto ranking = rank(sightings, FakeMap(), all_of_them(), false);
  EXPECT_FALSE(has(ranking, Verdict::kCreated));
  ASSERT_EQ(ranking.size(), 1U);
  for (const Assignment& assignment : ranking[0].assignments)
    EXPECT_EQ(assignment.verdict, Verdict::kClutter);
}

TEST(AssignmentRanking, NothingIsNewWhereTheSensorCouldNotTellItFromALandmark) {
  const FakeMap map = FakeMap().add({1.0, 0.0}, 0.5);  // the pose is uncertain
  const auto can_be_new = [&](double distance, double least_distance = 0.0) {
    AssociationOptions options = all_of_them();
    options.new_landmark_distance = least_distance;
    return has(rank({sighting({1.0 + distance, 0.0})}, map, options), Verdict::kCreated);
  };
  EXPECT_FALSE(can_be_new(0.15)) << "three sigma of the sensor";
  EXPECT_TRUE(can_be_new(0.4)) << "eight, though less than one of the pose";
  EXPECT_FALSE(can_be_new(0.4, 0.5));
}

TEST(AssignmentRanking, OneObjectSeenTwiceAtOnceIsNotTwoNewOnes) {
  for (const RankedAssignment& ranked :
       rank({sighting({1.02, 0.0}), sighting({1.0, 0.0})}, FakeMap(), all_of_them())) {
    const auto created = std::count_if(ranked.assignments.begin(), ranked.assignments.end(),
                                       [](const auto& made) { return made.verdict == Verdict::kCreated; });
    EXPECT_LE(created, 1);
  }
}

TEST(AssignmentRanking, KeepsNoMoreThanItMayAndTheLikeliestOfAll) {
  std::mt19937_64 random(8);
  const auto drawn = random_joint_case(&random, 5, 4, 0.8);
  const auto all = rank(drawn.sightings, drawn.map, all_of_them());
  for (const int most : {1, 3, 30}) {
    AssociationOptions options = all_of_them();
    options.max_hypotheses = most;
    const auto ranking = rank(drawn.sightings, drawn.map, options);
    EXPECT_LE(ranking.size(), static_cast<std::size_t>(most));
    EXPECT_GE(ranking.size(), 1U);
    EXPECT_LE(ranking[0].log_ratio, all[0].log_ratio + 1e-9);
  }
}

TEST(AssignmentRanking, DropsWhatIsFarLessLikelyThanTheBest) {
  AssociationOptions options;
  options.branch_width = 4.0;
  options.clutter_width = 2.0;
  const FakeMap map = FakeMap().add({1.0, 0.0});
  const auto ranking = rank({sighting({1.0, 0.0}), sighting({5.0, 0.0})}, map, options);
  for (const RankedAssignment& ranked : ranking) {
    EXPECT_GE(ranked.log_ratio, ranking[0].log_ratio - options.branch_width);
    EXPECT_NE(ranked.assignments[0].verdict, Verdict::kClutter) << "10.4 less likely than the landmark";
  }
  EXPECT_FALSE(has(ranking, Verdict::kClutter)) << "2.3 less likely than a new one, and it may be 2";
}

}  // namespace
}  // namespace kinect_ekf_slam
