#include "kinect_ekf_slam/estimators/fast_slam.h"

#include <gtest/gtest.h>

#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::motion;
using testing::pose_at;
using testing::Scenario;
using testing::seen;
using Type = EstimatorOptions::Type;

std::unique_ptr<SlamEstimator<Planar>> make(
    const EstimatorOptions& options, double sigma = 0.01,
    const AssociationOptions& association = testing::known_identities()) {
  return make_estimator<Planar>(options, association, pose_at<Planar>(Se2(), sigma));
}

/// After twenty steps among twelve landmarks, over seeds.
struct Outcome {
  double landmark_rmse = 0.0;  ///< m
  double pose_nees = 0.0;      ///< mean
};

Outcome outcome(const EstimatorOptions& given, int seeds) {
  Outcome outcome;
  double squared = 0.0;
  int count = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    EstimatorOptions options = given;
    options.seed = seed;
    Scenario<Planar> scenario(static_cast<std::uint64_t>(seed), 12);
    scenario.start_at(pose_at<Planar>(Se2(), 0.01));
    const auto estimator = make(options);
    for (int i = 0; i < 20; ++i) {
      estimator->predict(scenario.drive(testing::gentle_curve<Planar>()));
      estimator->observe(1 + i, scenario.look());
    }
    outcome.pose_nees += testing::nees(scenario, estimator->pose()) / seeds;
    for (const auto& landmark : estimator->landmarks()) {
      const auto id = static_cast<std::size_t>(landmark.info.source_id);
      squared += (landmark.position_in_map - scenario.landmarks()[id]).squaredNorm();
      ++count;
    }
  }
  outcome.landmark_rmse = std::sqrt(squared / count);
  return outcome;
}

TEST(FastSlam, MapsAsWellAsTheKalmanFilterForAWhile) {
  const Outcome ekf = outcome(testing::textbook(), 20);
  for (const Type type : {Type::kFastSlam1, Type::kFastSlam2}) {
    const Outcome particles = outcome(testing::textbook(type), 20);
    EXPECT_LT(particles.landmark_rmse, 1.15 * ekf.landmark_rmse);
    EXPECT_LT(particles.pose_nees, 4.0) << "3 when consistent";
  }
}

EstimatorOptions authors(Type type) {
  EstimatorOptions options = testing::textbook(type);
  options.draw_after = 1;
  return options;
}

/// Each draw costs: what waits with it keeps in its covariance what a draw would turn into luck.
TEST(FastSlam, MapsBetterAndIsLessSureThanTheAuthorsFirstWithAsManyParticles) {
  constexpr int kSeeds = 100;
  const Outcome draws = outcome(authors(Type::kFastSlam1), kSeeds);
  for (const Type type : {Type::kFastSlam1, Type::kFastSlam2}) {
    const Outcome waits = outcome(testing::textbook(type), kSeeds);
    EXPECT_LT(1.1 * waits.landmark_rmse, draws.landmark_rmse);
    EXPECT_LT(3.0 * waits.pose_nees, draws.pose_nees);
  }
}

/// 2.0 draws where the landmarks say that the robot is: there 1.0 has few of its particles.
TEST(FastSlam, TheAuthorsSecondMapsBetterThanTheirFirst) {
  constexpr int kSeeds = 100;
  const Outcome first = outcome(authors(Type::kFastSlam1), kSeeds);
  const Outcome second = outcome(authors(Type::kFastSlam2), kSeeds);
  EXPECT_LT(1.05 * second.landmark_rmse, first.landmark_rmse);
  EXPECT_LT(2.0 * second.pose_nees, first.pose_nees);
}

TEST(FastSlam, AnotherSeedGivesAnotherResult) {
  EstimatorOptions options = authors(Type::kFastSlam2);
  const Se2 first = [&] {
    const auto estimator = make(options);
    estimator->observe(1, {seen<Planar>({1.0, 0.0}, 1)});
    return estimator->pose().map_from_base;
  }();
  options.seed = 2;
  const auto estimator = make(options);
  estimator->observe(1, {seen<Planar>({1.0, 0.0}, 1)});
  EXPECT_NE(estimator->pose().map_from_base.log(), first.log());
}

/// Motion is drawn only when something is seen: until then particles predict as the Kalman filter does.
TEST(FastSlam, PredictsLikeTheKalmanFilterUntilSomethingIsSeen) {
  const auto ekf = make(testing::textbook());
  const auto particles = make(testing::textbook(Type::kFastSlam2));
  for (int i = 0; i < 50; ++i) {
    const auto step = motion<Planar>(Se2::exp({0.1, 0.0, 0.05}), 0.005);
    ekf->predict(step);
    particles->predict(step);
  }
  EXPECT_TRUE(testing::PoseNear(particles->pose().map_from_base, ekf->pose().map_from_base, 1e-9));
  EXPECT_TRUE(MatrixNear(particles->pose().covariance, ekf->pose().covariance, 1e-9));
}

/// A particle whose pose is not drawn is a Kalman filter, in all that it says.
template <class Space>
void expect_kalmans_numbers_while_nothing_is_drawn(Type type) {
  EstimatorOptions options = testing::textbook(type);
  options.particles = 3;
  options.draw_after = 13;
  Scenario<Space> scenario(7, 12);
  const auto initial = pose_at<Space>(typename Space::Pose(), 0.02);
  const auto particles = make_estimator<Space>(options, testing::known_identities(), initial);
  const auto ekf = make_estimator<Space>(testing::textbook(Type::kEkf), testing::known_identities(), initial);
  for (int i = 0; i < 30; ++i) {
    const auto step = scenario.drive(testing::gentle_curve<Space>());
    const auto sightings = scenario.look();
    for (const auto estimator : {particles.get(), ekf.get()}) {
      estimator->predict(step);
      estimator->observe(1 + i, sightings);
    }
  }
  const auto last_step = scenario.drive(testing::gentle_curve<Space>());
  for (const auto estimator : {particles.get(), ekf.get()}) estimator->predict(last_step);
  EXPECT_GT(ekf->landmarks().size(), 3U);
  EXPECT_TRUE(testing::PoseNear(particles->pose().map_from_base, ekf->pose().map_from_base, 1e-9));
  EXPECT_TRUE(MatrixNear(particles->pose().covariance, ekf->pose().covariance, 1e-9));
  EXPECT_TRUE(MatrixNear(particles->snapshot().covariance, ekf->snapshot().covariance, 1e-9));
  EXPECT_TRUE(MatrixNear(particles->snapshot().landmarks_in_map, ekf->snapshot().landmarks_in_map, 1e-9));
}

TEST(FastSlam, IsTheKalmanFilterWhileNoPoseIsDrawn) {
  for (const Type type : {Type::kFastSlam1, Type::kFastSlam2}) {
    expect_kalmans_numbers_while_nothing_is_drawn<Planar>(type);
    expect_kalmans_numbers_while_nothing_is_drawn<Spatial>(type);
  }
}

/// One sighting of one known landmark is a linear problem: the particles' mean and covariance are Kalman's,
/// as far as a thousand of them tell.
TEST(FastSlam, AgreesWithTheKalmanFilterOnOneSighting) {
  for (const Type type : {Type::kFastSlam1, Type::kFastSlam2}) {
    EstimatorOptions options = authors(type);
    options.particles = 4000;
    const auto particles = make(options, 1e-4);
    const auto ekf = make(testing::textbook(), 1e-4);
    for (const auto estimator : {particles.get(), ekf.get()}) {
      estimator->observe(1, {seen<Planar>({1.0, 0.2}, 1, 0.02)});
      estimator->predict({Se2(0.3, 0.0, 0.0), 0.03 * 0.03 * Eigen::Matrix3d::Identity()});
      estimator->observe(2, {seen<Planar>({0.66, 0.19}, 1, 0.02)});
    }
    EXPECT_TRUE(MatrixNear(particles->pose().map_from_base.translation(),
                           ekf->pose().map_from_base.translation(), 0.003));
    EXPECT_TRUE(MatrixNear(particles->pose().covariance, ekf->pose().covariance, 1e-4));
    EXPECT_TRUE(MatrixNear(particles->landmarks()[0].covariance, ekf->landmarks()[0].covariance, 1e-4));
  }
}

TEST(FastSlam, HeavyTailsSurviveAMotionThatTheOdometryDidNotTell) {
  const auto error_after_a_push = [](EstimatorOptions::MotionTail tail) {
    EstimatorOptions options = testing::textbook(Type::kFastSlam2);
    options.motion_tail = tail;
    AssociationOptions association = testing::known_identities(0.9999);
    const auto estimator = make(options, 0.001, association);
    const std::vector<Eigen::Vector2d> landmarks = {{2.0, 0.5}, {2.0, -0.5}, {1.0, 1.5}};
    Se2 truth;
    for (int i = 1; i <= 10; ++i) {
      if (i == 5) truth = truth * Se2(0.5, 0.3, 0.4);  // 25 sigma
      std::vector<Observation<Planar>> observations;
      observations.reserve(landmarks.size());
      for (int k = 0; k < 3; ++k) {
        observations.push_back(
            seen<Planar>(truth.inverse() * landmarks[static_cast<std::size_t>(k)], k, 0.02));
      }
      estimator->observe(i, observations);
      estimator->predict(motion<Planar>(Se2(), 0.02));
    }
    return (estimator->pose().map_from_base.translation() - truth.translation()).norm();
  };
  EXPECT_LT(error_after_a_push(EstimatorOptions::MotionTail::kCauchy), 0.1);
  EXPECT_GT(error_after_a_push(EstimatorOptions::MotionTail::kGaussian), 0.3);
}

/// What one particle takes for new and the others do not is not a landmark of the map.
TEST(FastSlam, AMinoritysLandmarkIsNotInTheMap) {
  AssociationOptions association;
  association.type = AssociationOptions::Type::kNearestNeighbor;
  EstimatorOptions options = testing::textbook(Type::kFastSlam1);
  const auto estimator = make(options, 0.001, association);
  estimator->observe(1, {seen<Planar>({2.0, 0.0}, kNoId), seen<Planar>({0.0, 2.0}, kNoId)});
  for (int i = 2; i < 30; ++i) {  // the motion is so poor that some particles see the landmarks elsewhere
    estimator->predict(motion<Planar>(Se2(), 0.12));
    estimator->observe(i, {seen<Planar>({2.0, 0.0}, kNoId), seen<Planar>({0.0, 2.0}, kNoId)});
    EXPECT_EQ(estimator->landmarks().size(), 2U) << i;
  }
}

/// Particles that have gone on learning say how uncertain the pose is, though the map that is shown stays.
TEST(FastSlam, AFixedMapComesBackWhenItMayChangeAgain) {
  Scenario<Planar> scenario(4, 8);
  const auto estimator = make(testing::textbook(Type::kFastSlam2));
  const auto run = [&](TimeNs first) {
    for (int i = 0; i < 20; ++i) {
      estimator->predict(scenario.drive(testing::gentle_curve<Planar>()));
      estimator->observe(first + i, scenario.look());
    }
  };
  run(1);
  estimator->set_map_fixed(true);
  const auto before = estimator->landmarks();
  run(100);
  EXPECT_TRUE(IsCovariance(estimator->snapshot().covariance));
  estimator->set_map_fixed(false);
  const auto after = estimator->landmarks();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_TRUE(MatrixNear(after[i].position_in_map, before[i].position_in_map, 1e-9));
    EXPECT_TRUE(MatrixNear(after[i].covariance, before[i].covariance, 1e-9));
  }
}

TEST(FastSlam, AMisplacedLandmarkIsPlacedAnewInEveryParticle) {
  EstimatorOptions options = testing::textbook(Type::kFastSlam2);
  options.replace_after = 3;
  const auto estimator = make(options);
  estimator->observe(1, {seen<Planar>({2.0, 0.0}, 7)});
  Verdict last = Verdict::kMatched;
  for (int i = 2; i <= 4; ++i) {
    last = estimator->observe(i, {seen<Planar>({-3.0, 1.0}, 7)}).assignments[0].verdict;
    if (i < 4) {
      EXPECT_EQ(last, Verdict::kOutsideGate) << i;
    }
  }
  EXPECT_EQ(last, Verdict::kCreated);
  ASSERT_EQ(estimator->landmarks().size(), 1U);
  EXPECT_EQ(estimator->landmarks()[0].info.id, 7);
  EXPECT_TRUE(MatrixNear(estimator->landmarks()[0].position_in_map, Eigen::Vector2d(-3.0, 1.0), 0.1));
}

}  // namespace
}  // namespace kinect_ekf_slam
