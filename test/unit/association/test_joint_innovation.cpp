#include "kinect_ekf_slam/association/joint_innovation.h"

#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/joint_case.h"

namespace kinect_ekf_slam {
namespace {

using testing::FakeMap;
using testing::JointCase;
using testing::random_joint_case;
using testing::sighting;

double log_determinant(const Eigen::MatrixXd& covariance) { return std::log(covariance.determinant()); }

TEST(JointInnovation, GrowsAsTheDenseMatricesDo) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const JointCase drawn = random_joint_case(&random, 12, 12, 2.0);
    JointInnovation<Planar> joint(drawn.map);
    std::vector<int> landmarks;
    double distance = 0.0;
    double log_det = 0.0;
    for (int k = 0; k < 12; ++k) {  // beyond its first capacity
      landmarks.push_back((5 * k + trial) % 12);
      const auto increment = joint.push(drawn.sightings[k], landmarks.back());
      ASSERT_TRUE(increment);
      distance += increment->squared_distance;
      log_det += increment->log_determinant;
      const double expected = drawn.squared_distance(landmarks);
      EXPECT_NEAR(joint.squared_distance(), expected, 1e-8 * expected) << "trial " << trial;
      EXPECT_NEAR(distance, expected, 1e-8 * expected) << "trial " << trial;
      EXPECT_NEAR(log_det, log_determinant(drawn.innovation_covariance(landmarks)), 1e-8)
          << "trial " << trial;
      EXPECT_EQ(joint.size(), k + 1);
    }
  }
}

TEST(JointInnovation, ALikelihoodIsThatOfTheSightingGivenTheOnesBefore) {
  std::mt19937_64 random(2);
  const JointCase drawn = random_joint_case(&random, 2, 2, 2.0);
  const auto log_density = [&](const std::vector<int>& landmarks) {
    return -0.5 * (drawn.squared_distance(landmarks) +
                   log_determinant(2.0 * kPi * drawn.innovation_covariance(landmarks)));
  };
  JointInnovation<Planar> joint(drawn.map);
  EXPECT_NEAR(joint.push(drawn.sightings[0], 0)->log_likelihood(), log_density({0}), 1e-9);
  EXPECT_NEAR(joint.push(drawn.sightings[1], 1)->log_likelihood(), log_density({0, 1}) - log_density({0}),
              1e-9);
}

TEST(JointInnovation, APairingTakenBackLeavesNoTrace) {
  std::mt19937_64 random(3);
  const JointCase drawn = random_joint_case(&random, 4, 4, 2.0);
  JointInnovation<Planar> joint(drawn.map);
  joint.push(drawn.sightings[0], 0);
  const double before = joint.squared_distance();
  const auto direct = joint.push(drawn.sightings[1], 1);
  joint.pop();
  joint.push(drawn.sightings[2], 3);
  joint.push(drawn.sightings[3], 2);
  joint.pop();
  joint.pop();
  EXPECT_EQ(joint.size(), 1);
  EXPECT_EQ(joint.squared_distance(), before);
  const auto again = joint.push(drawn.sightings[1], 1);
  EXPECT_EQ(again->squared_distance, direct->squared_distance);
  EXPECT_EQ(again->log_determinant, direct->log_determinant);
}

TEST(JointInnovation, RefusesWhatIsNotPositiveDefinite) {
  FakeMap map = FakeMap().add({1.0, 0.0}).add({2.0, 0.0});
  map.set_covariance(1, -Eigen::Matrix2d::Identity());
  JointInnovation<Planar> joint(map);
  ASSERT_TRUE(joint.push(sighting({1.1, 0.0}), 0));
  const double before = joint.squared_distance();
  EXPECT_FALSE(joint.push(sighting({2.0, 0.0}), 1));
  EXPECT_FALSE(joint.push(sighting({std::nan(""), 0.0}), 0));
  EXPECT_EQ(joint.size(), 1);
  EXPECT_EQ(joint.squared_distance(), before);
}

}  // namespace
}  // namespace kinect_ekf_slam
