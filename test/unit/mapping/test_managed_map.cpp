/// What makes a landmark believed in, and what takes it off the map.
#include "kinect_ekf_slam/mapping/managed_map.h"

#include <gtest/gtest.h>

#include <optional>
#include <stdexcept>

#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::motion;
using testing::pose_at;
using testing::seen;

LifeCycleOptions careful() {
  LifeCycleOptions options;
  options.confirm_sightings = 3;
  return options;
}

/// Looks with identities or without; a second passes between two looks.
class Keeper {
 public:
  explicit Keeper(const LifeCycleOptions& options, bool knows_identities = false,
                  const EstimatorOptions& estimator = testing::textbook()) {
    auto filter = make_kalman<Planar>(
        estimator, knows_identities ? testing::known_identities(0.999) : AssociationOptions(),
        pose_at<Planar>(Se2(), 1e-3));
    map.emplace(std::move(filter), options);
  }
  UpdateReport look(const std::vector<Eigen::Vector2d>& points, int identity = kNoId) {
    std::vector<Observation<Planar>> observations;
    for (const Eigen::Vector2d& point : points) observations.push_back(seen<Planar>(point, identity, 0.03));
    return map->observe(to_nanoseconds(++seconds), observations);
  }
  void look_in_vain(int looks) {
    for (int i = 0; i < looks; ++i) look({});
  }
  void move() { map->predict(motion<Planar>(Se2({0.0, 0.1}, 0.0), 1e-4)); }
  std::size_t in_map() const { return map->landmarks().size(); }
  std::size_t believed() const { return map->snapshot().infos.size(); }

  std::optional<ManagedMap<Planar>> map;
  double seconds = 0.0;
};

TEST(ManagedMap, ALandmarkIsProvisionalUntilSightingsAndMotionAgree) {
  Keeper keeper(careful());
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(keeper.look({{1.0, 0.0}}).confirmed.empty()) << "stands still";
  EXPECT_FALSE(keeper.map->landmarks()[0].info.confirmed);
  EXPECT_EQ(keeper.believed(), 0U) << "a snapshot has what is believed";
  keeper.move();
  EXPECT_EQ(keeper.look({{1.0, -0.1}}).confirmed.size(), 1U);
  EXPECT_TRUE(keeper.map->landmarks()[0].info.confirmed);
  EXPECT_EQ(keeper.believed(), 1U);

  Keeper moving(careful());
  moving.look({{1.0, 0.0}});
  moving.move();
  EXPECT_TRUE(moving.look({{1.0, -0.1}}).confirmed.empty()) << "two sightings";
  EXPECT_EQ(moving.look({{1.0, -0.1}}).confirmed.size(), 1U);
}

TEST(ManagedMap, ABurstOfErrorsIsNoLandmark) {
  LifeCycleOptions options = careful();
  options.confirm_time = 5.0;  // s; a look each second
  Keeper keeper(options);
  keeper.look({{1.0, 0.0}});
  keeper.move();
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(keeper.look({{1.0, -0.1}}).confirmed.empty());
  EXPECT_EQ(keeper.look({{1.0, -0.1}}).confirmed.size(), 1U);
}

TEST(ManagedMap, ByDefaultALandmarkIsBelievedInAtOnce) {
  Keeper keeper((LifeCycleOptions()));
  keeper.look({{1.0, 0.0}});
  EXPECT_EQ(keeper.believed(), 1U);
}

TEST(ManagedMap, ForgetsClutter) {
  Keeper keeper(careful());
  const int clutter = keeper.look({{1.0, 0.0}}).assignments[0].landmark;
  keeper.look_in_vain(6);
  EXPECT_EQ(keeper.in_map(), 1U);
  EXPECT_EQ(keeper.look({}).removed, std::vector<int>{clutter});
  EXPECT_EQ(keeper.in_map(), 0U);
}

TEST(ManagedMap, AMisreadLandmarkThatIsPlacedAnewIsBelievedInAgain) {
  EstimatorOptions replacing = testing::textbook();
  replacing.replace_after = 3;
  Keeper keeper(LifeCycleOptions(), true, replacing);
  keeper.look({{1.0, 0.0}}, 7);
  for (int i = 0; i < 3; ++i) keeper.look({{3.0, 2.0}}, 7);
  ASSERT_TRUE(
      testing::MatrixNear(keeper.map->landmarks()[0].position_in_map, Eigen::Vector2d(3.0, 2.0), 0.01));
  EXPECT_EQ(keeper.believed(), 1U);
}

LifeCycleOptions merging() {
  LifeCycleOptions options;
  options.merge_distance = 0.5;
  return options;
}

/// Two landmarks 0.3 m apart, by their identities.
void look_at_both(Keeper* keeper, bool together) {
  const auto first = seen<Planar>({1.0, 0.0}, 1, 0.1);
  const auto second = seen<Planar>({1.0, 0.3}, 2, 0.1);
  if (together) {
    keeper->map->observe(to_nanoseconds(++keeper->seconds), {first, second});
  } else {
    keeper->map->observe(to_nanoseconds(++keeper->seconds), {first});
    keeper->map->observe(to_nanoseconds(++keeper->seconds), {second});
  }
}

TEST(ManagedMap, DuplicatesBecomeOneAndTwoThatWereSeenTogetherNever) {
  Keeper apart(merging(), true);
  look_at_both(&apart, false);
  EXPECT_EQ(apart.in_map(), 1U);
  Keeper together(merging(), true);
  for (int i = 0; i < 5; ++i) look_at_both(&together, true);
  EXPECT_EQ(together.in_map(), 2U);
}

TEST(ManagedMap, WhatADuplicateWasSeenTogetherWithStaysTwo) {
  Keeper keeper(merging(), true);
  const auto at = [&](std::vector<Observation<Planar>> observations) {
    return keeper.map->observe(to_nanoseconds(keeper.seconds += 0.1), observations);
  };
  const auto first = seen<Planar>({1.0, 0.0}, 1, 0.1);
  const auto other = seen<Planar>({1.0, 0.3}, 2, 0.1);
  const auto duplicate = seen<Planar>({1.0, 0.02}, 3, 0.1);
  keeper.seconds = 1.0;
  at({});  // merging waits a second
  for (int i = 0; i < 5; ++i) at({first});
  for (int i = 0; i < 2; ++i) at({duplicate, other});
  for (int i = 0; i < 40; ++i) at({});
  EXPECT_EQ(keeper.in_map(), 2U) << "the duplicate and the first are one, and not the other";
}

TEST(ManagedMap, WhatIsSeenDoubleNowAndThenIsOne) {
  LifeCycleOptions options = careful();
  options.merge_distance = 0.5;
  options.confirm_motion = 0.0;
  Keeper keeper(options, true);
  const auto one = seen<Planar>({1.0, 0.0}, 1, 0.1);
  const auto other = seen<Planar>({1.0, 0.3}, 2, 0.1);
  const auto look = [&](const std::vector<Observation<Planar>>& observations) {
    keeper.map->observe(to_nanoseconds(keeper.seconds += 0.1), observations);
  };
  for (int i = 0; i < 60; ++i)
    look(i % 3 == 1 ? std::vector<Observation<Planar>>{one, other} : std::vector<Observation<Planar>>{one});
  EXPECT_EQ(keeper.believed(), 1U);
  for (int i = 0; i < 60; ++i) look({one, other});
  EXPECT_EQ(keeper.believed(), 2U) << "two that are seen as often as each other";
}

TEST(ManagedMap, ALoadedMapKnowsNothingOfWhatWasSeenBefore) {
  Keeper keeper(merging(), true);
  for (int i = 0; i < 5; ++i) look_at_both(&keeper, true);
  const auto state = keeper.map->snapshot();
  keeper.map->restore(state);
  keeper.seconds = 0.0;  // a recording that starts again
  keeper.look({});
  keeper.look({});
  EXPECT_EQ(keeper.in_map(), 1U);
}

LifeCycleOptions removing() {
  LifeCycleOptions options;
  options.remove_after_visits = 3;
  return options;
}

TEST(ManagedMap, RemovesWhatAVisitLooksForInVain) {
  Keeper keeper(removing());
  keeper.look({{1.5, 0.0}});
  keeper.look_in_vain(6);
  EXPECT_EQ(keeper.in_map(), 1U) << "of one sighting nothing is known about how often it is seen";
  keeper.look_in_vain(1);
  EXPECT_EQ(keeper.in_map(), 0U) << "one sighting does not outweigh a visit";

  Keeper supported(removing());
  for (int i = 0; i < 20; ++i) supported.look({{1.5, 0.0}});
  supported.seconds += 10.0;  // the next visit
  for (int i = 0; i < 20; ++i) supported.look({{1.5, 0.0}});
  for (const std::size_t left : {1U, 1U, 0U}) {
    supported.look_in_vain(5);
    EXPECT_EQ(supported.in_map(), left);
    supported.seconds += 10.0;
  }

  Keeper seen_once(removing());
  for (int i = 0; i < 20; ++i) seen_once.look({{1.5, 0.0}});
  for (const std::size_t left : {1U, 0U}) {
    seen_once.look_in_vain(5);
    EXPECT_EQ(seen_once.in_map(), left) << "many sightings of one visit are one error, if it lasted";
    seen_once.seconds += 10.0;
  }
}

TEST(ManagedMap, ExpectsWhatIsSeldomSeenSeldom) {
  for (const int looks_per_sighting : {1, 3}) {
    Keeper keeper(removing());
    for (int i = 0; i < 30; ++i) i % looks_per_sighting == 0 ? keeper.look({{1.5, 0.0}}) : keeper.look({});
    for (int visit = 0; visit < 4; ++visit) {
      keeper.seconds += 10.0;
      keeper.look_in_vain(5);
    }
    EXPECT_EQ(keeper.in_map(), looks_per_sighting == 1 ? 0U : 1U)
        << "five misses in a row are nothing unusual for what is seen in one look of three";
  }
}

TEST(ManagedMap, TellsWhatItLookedForInVainByHowOftenItWasSeen) {
  Keeper keeper(removing());
  for (int i = 0; i < 4; ++i) keeper.look({{1.5, 0.0}});
  EXPECT_EQ(keeper.look({{1.5, 0.0}}).missed, 0.0);
  EXPECT_NEAR(keeper.look({}).missed, 1.0, 1e-9);
  EXPECT_NEAR(keeper.look({}).missed, 5.0 / 6.0, 1e-9);
  Keeper unsure(careful());
  unsure.look({{1.5, 0.0}});
  EXPECT_EQ(unsure.look({{1.5, 0.0}}).provisional, 1);
}

TEST(ManagedMap, DoesNotMissWhatIsHiddenOrOutOfView) {
  Keeper hidden(removing());
  hidden.look({{2.0, 0.0}});
  for (int i = 0; i < 20; ++i) hidden.look({{1.0, 0.0}});
  EXPECT_EQ(hidden.in_map(), 2U);
  for (const Eigen::Vector2d& point :
       {Eigen::Vector2d(3.0, 0.0), Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(-1.0, 0.0)}) {
    Keeper out_of_view(removing());
    out_of_view.look({point});
    out_of_view.look_in_vain(20);
    EXPECT_EQ(out_of_view.in_map(), 1U) << point.transpose();
  }
}

TEST(ManagedMap, MissesWhatItSeesThrough) {
  Keeper keeper(removing());
  keeper.look({{1.0, 0.0}});
  for (int i = 0; i < 20; ++i) keeper.look({{2.0, 0.0}});
  ASSERT_EQ(keeper.in_map(), 1U) << "something behind it is seen: nothing hides it";
  EXPECT_NEAR(keeper.map->landmarks()[0].position_in_map.x(), 2.0, 0.1);
}

TEST(ManagedMap, AFixedMapStaysAsItIs) {
  LifeCycleOptions options = careful();
  options.remove_after_visits = 1;
  options.merge_distance = 1.0;
  Keeper keeper(options);
  keeper.look({{1.0, 0.0}, {1.5, 0.3}});
  keeper.map->set_map_fixed(true);
  keeper.look_in_vain(30);
  keeper.look({{2.0, -0.5}});
  EXPECT_EQ(keeper.in_map(), 2U);
  keeper.map->set_map_fixed(false);
  keeper.look({});
  EXPECT_EQ(keeper.in_map(), 0U);
}

TEST(SlamFactory, RefusesSeveralHypothesesOfParticles) {
  AssociationOptions association;
  association.type = AssociationOptions::Type::kMultiHypothesis;
  EXPECT_THROW(make_slam<Planar>(testing::textbook(EstimatorOptions::Type::kFastSlam1), association,
                                 LifeCycleOptions(), PoseEstimate<Planar>()),
               std::invalid_argument);
}

}  // namespace
}  // namespace kinect_ekf_slam
