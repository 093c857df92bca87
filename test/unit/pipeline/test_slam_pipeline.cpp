#include "kinect_ekf_slam/pipeline/slam_pipeline.h"

#include <gtest/gtest.h>

#include <limits>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/frames.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::detection;
using testing::detection_frame;
using testing::gyro_frame;
using testing::MatrixNear;
using testing::odometry_frame;
using testing::wide_open;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double x_of(const SlamResult& result) { return result.pose.map_from_base.translation().x(); }
double yaw_of(const Pose3d& pose) { return Planar::pose_from_3d(pose.map_from_base).angle(); }

TEST(SlamPipeline, TheMotionOfAFrameHoldsUntilTheNext) {
  const auto pipeline = make_pipeline(wide_open());
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(1.0, 1.0))), 0.0, 1e-12);
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(1.5, 2.0))), 0.5, 1e-12);
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(1.75, 0.0))), 1.0, 1e-12);
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(2.5, 0.0))), 1.0, 1e-12);
}

TEST(SlamPipeline, ThePoseMovesBeforeTheFirstLandmark) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(odometry_frame(1.0, 1.0, 0.5));
  const SlamResult start = pipeline->process(odometry_frame(1.1, 1.0, 0.5));
  const SlamResult later = pipeline->process(odometry_frame(1.9, 1.0, 0.5));
  EXPECT_GT(x_of(later), x_of(start));
  EXPECT_NEAR(yaw_of(later.pose), 0.45, 1e-12);
  EXPECT_GT(later.pose.covariance.trace(), start.pose.covariance.trace());
  EXPECT_TRUE(pipeline->map().empty());
}

TEST(SlamPipeline, StartsWhereTheOptionsSay) {
  PipelineOptions options = wide_open();
  options.initial_pose.x = 2.0;
  options.initial_pose.y = -1.0;
  options.initial_pose.yaw_deg = 90.0;
  options.initial_pose.position_sigma = 0.2;
  options.initial_pose.heading_sigma_deg = 3.0;
  const Pose3d pose = make_pipeline(options)->process(odometry_frame(1.0, 0.0)).pose;
  EXPECT_TRUE(MatrixNear(pose.map_from_base.translation(), Eigen::Vector3d(2.0, -1.0, 0.0), 1e-12));
  EXPECT_NEAR(yaw_of(pose), 0.5 * kPi, 1e-12);
  EXPECT_NEAR(pose.covariance(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(pose.covariance(5, 5), std::pow(radians(3.0), 2), 1e-12);
}

TEST(SlamPipeline, SaturatesBeforeItMoves) {
  PipelineOptions options = wide_open();
  options.input.max_linear_speed = 0.22;
  const auto pipeline = make_pipeline(options);
  pipeline->process(odometry_frame(1.0, 5.0));
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(2.0, 5.0))), 0.22, 1e-12);
}

TEST(SlamPipeline, TurnsWithTheGyroThatItIsToldToBelieve) {
  PipelineOptions options = wide_open();
  options.input.heading_source = HeadingSource::kImu;
  const auto pipeline = make_pipeline(options);
  pipeline->process(odometry_frame(1.0, 0.1, 0.5));
  pipeline->process(gyro_frame(1.0, 0.3));
  EXPECT_NEAR(yaw_of(pipeline->process(odometry_frame(1.05, 0.1, 0.5)).pose), 0.015, 1e-12);
}

/// First it moves, then it looks: a landmark is placed from where the robot is at the time of the sighting.
TEST(SlamPipeline, PredictsBeforeItObserves) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(odometry_frame(1.0, 1.0));
  const SlamResult result = pipeline->process(detection_frame(1.5, {detection(2.0, 0.0, 1)}));
  ASSERT_EQ(pipeline->map().size(), 1U);
  EXPECT_NEAR(pipeline->map()[0].position_in_map.x(), 2.5, 1e-12);
  EXPECT_NEAR(result.outcomes[0].position_in_map.x(), 2.5, 1e-12);
}

TEST(SlamPipeline, CorrectsThePoseAndNotTheDeadReckoning) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(odometry_frame(1.0, 1.0));
  pipeline->process(detection_frame(1.0, {detection(2.0, 0.0, 1), detection(2.0, 1.0, 2)}));
  const SlamResult result =
      pipeline->process(detection_frame(1.5, {detection(1.6, 0.0, 1), detection(1.6, 1.0, 2)}));
  EXPECT_EQ(result.outcomes[0].verdict, Verdict::kMatched);
  EXPECT_EQ(result.dof, 4);
  EXPECT_GT(result.nis, 0.0);
  EXPECT_LT(x_of(result), 0.499);
  EXPECT_NEAR(result.dead_reckoned.translation().x(), 0.5, 1e-12);
}

TEST(SlamPipeline, RefusesDetectionsOlderThanTheEstimate) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(odometry_frame(1.0, 1.0));
  const SlamResult before = pipeline->process(odometry_frame(2.0, 1.0));
  const SlamResult late = pipeline->process(detection_frame(1.5, {detection(2.0, 0.0, 1)}));
  EXPECT_EQ(late.outcomes[0].verdict, Verdict::kLate);
  EXPECT_TRUE(pipeline->map().empty());
  EXPECT_EQ(late.pose.stamp, before.pose.stamp);
  EXPECT_TRUE(MatrixNear(late.pose.map_from_base.matrix(), before.pose.map_from_base.matrix(), 0.0));
}

TEST(SlamPipeline, ARepeatedStampMovesNothing) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(odometry_frame(1.0, 1.0));
  const SlamResult once = pipeline->process(odometry_frame(2.0, 1.0));
  for (int i = 0; i < 5; ++i) {
    const SlamResult again = pipeline->process(odometry_frame(2.0, 1.0));
    EXPECT_TRUE(MatrixNear(again.pose.map_from_base.matrix(), once.pose.map_from_base.matrix(), 0.0));
    EXPECT_TRUE(MatrixNear(again.pose.covariance, once.pose.covariance, 0.0));
  }
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(2.5, 1.0))), 1.5, 1e-12);
}

TEST(SlamPipeline, CountsWhatIsInvalidAndTakesTheRest) {
  std::vector<Detection> detections(6, detection(2.0, 0.0, 1));
  detections[0].position_in_base.x() = kNan;
  detections[1].covariance_in_base(0, 0) = kNan;
  detections[2].covariance_in_base = -Eigen::Matrix3d::Identity();
  detections[3].covariance_in_base(0, 1) = 0.002;  // not symmetric
  detections[4].position_in_base.y() = std::numeric_limits<double>::infinity();
  const auto pipeline = make_pipeline(wide_open());
  const SlamResult result = pipeline->process(detection_frame(1.0, detections));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(result.outcomes[i].verdict, Verdict::kInvalid) << i;
  EXPECT_EQ(result.outcomes[5].verdict, Verdict::kCreated);
  EXPECT_TRUE(result.finite);
  EXPECT_EQ(pipeline->map().size(), 1U);
}

/// The depth alone does not tell: a huge height of a tilted sensor or a huge mounting passes the range gate.
TEST(SlamPipeline, APlaceThatIsNowhereIsInvalid) {
  const auto pipeline = make_pipeline(wide_open());
  Detection nowhere = detection(2.0, 0.0, 1);
  for (const double huge : {1e9, -1e155, 1.7e308}) {
    nowhere.position_in_base.y() = huge;
    const SlamResult result = pipeline->process(detection_frame(1.0, {nowhere, detection(2.0, 1.0, 2)}));
    EXPECT_EQ(result.outcomes[0].verdict, Verdict::kInvalid) << huge;
    EXPECT_TRUE(is_accepted(result.outcomes[1].verdict)) << huge;
  }
  EXPECT_EQ(pipeline->map().size(), 1U);
  EXPECT_TRUE(pipeline->save().covariance.allFinite());
}

TEST(SlamPipeline, GatesByRangeAndKeepsTheOrderOfOutcomes) {
  PipelineOptions options = wide_open();
  options.sensor = SensorOptions();
  const auto pipeline = make_pipeline(options);
  const SlamResult result = pipeline->process(
      detection_frame(1.0, {detection(0.5, 0.0, 4), detection(1.0, 0.0, 5), detection(3.0, 0.0, 6)}));
  EXPECT_EQ(result.outcomes[0].verdict, Verdict::kOutOfRange);
  EXPECT_EQ(result.outcomes[1].verdict, Verdict::kCreated);
  EXPECT_EQ(result.outcomes[2].verdict, Verdict::kOutOfRange);
  EXPECT_EQ(result.outcomes[1].source_id, 5);
}

/// The joint update grows with the cube of the sightings: a message of thousands would stop the robot's node.
TEST(SlamPipeline, UsesNoMoreDetectionsOfOneMessageThanAllowed) {
  PipelineOptions options = wide_open();
  options.sensor.max_detections = 2;
  const auto pipeline = make_pipeline(options);
  const SlamResult result = pipeline->process(detection_frame(
      1.0, {detection(1e4, 0.0, 3), detection(1.0, 0.0, 4), detection(2.0, 0.0, 5), detection(3.0, 0.0, 6)}));
  EXPECT_EQ(result.outcomes[0].verdict, Verdict::kOutOfRange) << "what is not used does not count";
  EXPECT_EQ(result.outcomes[1].verdict, Verdict::kCreated);
  EXPECT_EQ(result.outcomes[2].verdict, Verdict::kCreated);
  EXPECT_EQ(result.outcomes[3].verdict, Verdict::kTooMany);
  EXPECT_EQ(pipeline->map().size(), 2U);
}

TEST(SlamPipeline, WithoutACovarianceTheModelSaysHowSureASightingIs) {
  const auto pipeline = make_pipeline(wide_open());
  Detection bare = detection(1.0, 0.0, 1);
  bare.covariance_in_base.setZero();
  EXPECT_EQ(pipeline->process(detection_frame(1.0, {bare})).outcomes[0].verdict, Verdict::kCreated);
  EXPECT_NEAR(pipeline->map()[0].covariance(0, 0), 0.00121425 + 1e-6, 1e-8);
}

TEST(SlamPipeline, LookingAndSeeingNothingIsNotTheSameAsNotLooking) {
  const auto pipeline = make_pipeline(wide_open());
  EXPECT_TRUE(pipeline->process(detection_frame(1.0, {})).looked);
  EXPECT_FALSE(pipeline->process(odometry_frame(1.1, 0.0)).looked);
}

TEST(SlamPipeline, LooksAheadAsItWillGo) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(odometry_frame(1.0, 1.0, 0.3));
  pipeline->process(detection_frame(1.2, {detection(2.0, 0.0, 1)}));
  const std::deque<SensorFrame> waiting = {odometry_frame(1.3, 0.8, 0.5), gyro_frame(1.35, 0.4),
                                           odometry_frame(1.4, 0.6, -0.2), odometry_frame(1.9, 3.0, 3.0)};
  const SavedState before = pipeline->save();
  const Pose3d ahead = pipeline->look_ahead(waiting, to_nanoseconds(1.6));
  EXPECT_TRUE(MatrixNear(pipeline->save().covariance, before.covariance, 0.0));
  EXPECT_TRUE(MatrixNear(pipeline->save().pose, before.pose, 0.0));

  for (int i = 0; i < 3; ++i) pipeline->process(waiting[i]);
  SensorFrame nothing;
  nothing.stamp = to_nanoseconds(1.6);
  const Pose3d later = pipeline->process(nothing).pose;
  EXPECT_EQ(ahead.stamp, later.stamp);
  EXPECT_TRUE(MatrixNear(ahead.map_from_base.matrix(), later.map_from_base.matrix(), 1e-12));
  EXPECT_TRUE(MatrixNear(ahead.covariance, later.covariance, 1e-12));
}

TEST(SlamPipeline, AGapInTheOdometryGrowsTheUncertainty) {
  PipelineOptions options = wide_open();
  options.input.max_odometry_gap = 0.5;
  const auto with_gap = make_pipeline(options);
  with_gap->process(odometry_frame(1.0, 1.0));
  const SlamResult result = with_gap->process(odometry_frame(5.0, 1.0));
  EXPECT_NEAR(x_of(result), 0.5, 1e-12) << "the velocity holds half a second";
  const auto without = make_pipeline(options);
  without->process(odometry_frame(1.0, 1.0));
  const SlamResult held = without->process(odometry_frame(1.5, 1.0));
  EXPECT_GT(result.pose.covariance(0, 0), held.pose.covariance(0, 0) + 3.0);  // 1 m/s for 3.5 s
}

/// A robot that creeps and stops often, with a biased gyro: it neither runs away nor turns while it stands.
TEST(SlamPipeline, KeepsItsPlaceInASlowStopAndGoRun) {
  PipelineOptions options;
  options.association.type = AssociationOptions::Type::kKnown;
  const auto pipeline = make_pipeline(options);
  double truth = 0.0;
  SlamResult result;
  for (int i = 0; i < 3000; ++i) {  // 20 Hz, 150 s
    const double time = 1.0 + 0.05 * i;
    const double speed = (i / 100) % 3 == 1 ? 0.02 : 0.0;
    pipeline->process(gyro_frame(time, 0.02));
    result = pipeline->process(odometry_frame(time, speed));
    if (i % 20 == 0) {
      result = pipeline->process(
          detection_frame(time, {detection(2.4 - truth, 0.5, 1), detection(2.4 - truth, -0.5, 2)}));
    }
    truth += 0.05 * speed;
  }
  EXPECT_NEAR(pipeline->gyro_bias().z(), 0.02, 1e-3);
  EXPECT_NEAR(x_of(result), truth, 0.02);
  EXPECT_NEAR(yaw_of(result.pose), 0.0, 0.01);
  EXPECT_EQ(pipeline->map().size(), 2U);
}

TEST(SlamPipeline, SavesAndLoads) {
  const auto first = make_pipeline(wide_open());
  first->process(odometry_frame(1.0, 0.5));
  first->process(detection_frame(1.5, {detection(2.0, 0.0, 1), detection(1.0, 1.0, 2)}));
  const SavedState saved = first->save();
  EXPECT_EQ(saved.space, "planar");
  EXPECT_EQ(saved.stamp, to_nanoseconds(1.5));

  const auto second = make_pipeline(wide_open());
  second->load(saved, true);
  const SavedState again = second->save();
  EXPECT_TRUE(MatrixNear(again.pose, saved.pose, 0.0));
  EXPECT_TRUE(MatrixNear(again.landmarks_in_map, saved.landmarks_in_map, 0.0));
  EXPECT_TRUE(MatrixNear(again.covariance, saved.covariance, 0.0));
  EXPECT_EQ(again.infos[1].source_id, 2);
}

TEST(SlamPipeline, LoadsAMapUnderThePoseItHas) {
  const auto first = make_pipeline(wide_open());
  first->process(detection_frame(1.0, {detection(2.0, 0.0, 1)}));
  const auto second = make_pipeline(wide_open());
  Pose3d here;
  here.map_from_base.translation().x() = 7.0;
  here.covariance *= 100.0;
  second->set_pose(here);
  second->load(first->save(), false);
  const SavedState state = second->save();
  EXPECT_NEAR(state.pose(0), 7.0, 1e-12);
  EXPECT_TRUE(state.covariance.bottomLeftCorner(2, 3).isZero(0.0));
  EXPECT_NEAR(second->map()[0].position_in_map.x(), 2.0, 1e-12);
}

TEST(SlamPipeline, RefusesAMapOfAnotherSpaceAndKeepsItsOwn) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(detection_frame(1.0, {detection(2.0, 0.0, 1)}));
  SavedState other = pipeline->save();
  other.space = "spatial";
  other.infos.clear();
  EXPECT_THROW(pipeline->load(other, true), std::invalid_argument);
  EXPECT_EQ(pipeline->map().size(), 1U);
}

/// A map of an earlier run, or of a bag that starts again: its sightings are no echo of those of this run.
TEST(SlamPipeline, ALoadedMapWasNotSeenInThisRun) {
  PipelineOptions options = wide_open();
  options.sensor.correlation_time = 1.0;
  const auto first = make_pipeline(options);
  first->process(detection_frame(1000.0, {detection(2.0, 0.0, 1), detection(2.0, 1.0, 2)}));
  const auto second = make_pipeline(options);
  second->set_mode(Mode::kLocalization);
  second->load(first->save(), true);
  Pose3d unsure;
  unsure.covariance = Matrix6d::Identity();
  second->set_pose(unsure);
  const SlamResult result = second->process(
      detection_frame(1.0, {detection(2.0, 0.0, 1), detection(2.0, 1.0, 2)}));  // time went back
  EXPECT_EQ(result.outcomes[0].verdict, Verdict::kMatched);
  EXPECT_LT(result.pose.covariance(0, 0), 0.1);
}

TEST(SlamPipeline, LocalisationLeavesTheMapAlone) {
  const auto pipeline = make_pipeline(wide_open());
  pipeline->process(detection_frame(1.0, {detection(2.0, 0.0, 1)}));
  const SavedState before = pipeline->save();
  pipeline->set_mode(Mode::kLocalization);
  const SlamResult result =
      pipeline->process(detection_frame(2.0, {detection(2.05, 0.0, 1), detection(1.0, 1.0, 9)}));
  EXPECT_EQ(result.outcomes[0].verdict, Verdict::kMatched);
  EXPECT_EQ(result.outcomes[1].verdict, Verdict::kNotInMap);
  const SavedState after = pipeline->save();
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map, before.landmarks_in_map, 0.0));
  EXPECT_TRUE(
      MatrixNear(after.covariance.bottomRightCorner(2, 2), before.covariance.bottomRightCorner(2, 2), 0.0));
}

/// Correlated errors are no more independent because the map stands still.
TEST(SlamPipeline, LocalisationDoesNotTakeEchoesForNews) {
  PipelineOptions options = wide_open();
  options.sensor.correlation_time = 1.0;
  const auto sigma_after_a_minute = [&](double correlation_time) {
    options.sensor.correlation_time = correlation_time;
    const auto pipeline = make_pipeline(options);
    pipeline->process(detection_frame(1.0, {detection(2.0, 0.0, 1, 1e-3), detection(2.0, 1.0, 2, 1e-3)}));
    pipeline->set_mode(Mode::kLocalization);
    Pose3d unsure;
    unsure.covariance = Matrix6d::Identity();
    pipeline->set_pose(unsure);
    SlamResult result;
    for (int i = 0; i < 100; ++i) {
      result = pipeline->process(
          detection_frame(100.0 + 0.1 * i, {detection(2.0, 0.0, 1), detection(2.0, 1.0, 2)}));
    }
    return std::sqrt(result.pose.covariance(1, 1));
  };
  EXPECT_GT(sigma_after_a_minute(1.0), 3.0 * sigma_after_a_minute(0.0));
}

const std::vector<Eigen::Vector2d> kCylinders = {
    {1.0, 0.3}, {3.2, -0.8}, {2.1, 2.4}, {-1.5, 1.7}, {-2.2, -1.1}};

/// A pipeline that localises in a map of the cylinders and believes to be at the origin.
std::unique_ptr<SlamPipeline> localisation(bool relocalize_when_lost) {
  PipelineOptions options = wide_open();
  options.association.type = AssociationOptions::Type::kNearestNeighbor;
  options.relocalize_when_lost = relocalize_when_lost;
  auto pipeline = make_pipeline(options);
  std::vector<Detection> detections;
  for (const Eigen::Vector2d& place : kCylinders)
    detections.push_back(detection(place.x(), place.y(), kNoId, 0.02));
  pipeline->process(detection_frame(1.0, detections));
  pipeline->set_mode(Mode::kLocalization);
  return pipeline;
}

/// Drives a circle from `truth` on, seeing all cylinders, until the robot is found; the last result.
SlamResult drive_until_found(SlamPipeline* pipeline, Se2* truth, double start = 10.0) {
  SlamResult result;
  for (int i = 0; i < 300 && result.localization != Localization::kFound; ++i) {
    const double time = start + 0.1 * i;
    pipeline->process(odometry_frame(time, 0.5, 0.4));
    *truth = *truth * Se2::exp({0.05, 0.0, 0.04});
    std::vector<Detection> detections;
    for (const Eigen::Vector2d& place : kCylinders) {
      const Eigen::Vector2d in_base = truth->inverse() * place;
      detections.push_back(detection(in_base.x(), in_base.y(), kNoId));
    }
    result = pipeline->process(detection_frame(time + 0.1, detections));
  }
  return result;
}

TEST(SlamPipeline, FindsTheRobotWhenItIsAskedTo) {
  const auto pipeline = localisation(false);
  Se2 truth(0.8, -1.5, 2.0);
  EXPECT_EQ(drive_until_found(pipeline.get(), &truth).localization, Localization::kLost)
      << "nobody asked, but it says so";
  truth = Se2(0.8, -1.5, 2.0);
  pipeline->relocalize();
  EXPECT_GT(pipeline->look_ahead({}, 0).covariance(0, 0), 25.0) << "unknown, until it is found";
  const SlamResult result = drive_until_found(pipeline.get(), &truth, 100.0);
  ASSERT_EQ(result.localization, Localization::kFound);
  EXPECT_TRUE(testing::PoseNear(Planar::pose_from_3d(result.pose.map_from_base), truth, 0.1));
  EXPECT_LT(result.pose.covariance(0, 0), 0.1 * 0.1);
}

TEST(SlamPipeline, NoticesByItselfThatTheRobotWasCarriedAway) {
  const auto pipeline = localisation(true);
  Se2 truth(0.8, -1.5, 2.0);
  const SlamResult result = drive_until_found(pipeline.get(), &truth);
  ASSERT_EQ(result.localization, Localization::kFound);
  EXPECT_TRUE(testing::PoseNear(Planar::pose_from_3d(result.pose.map_from_base), truth, 0.1));
}

/// Here it begins to map the place anew, and what it maps fits what it sees.
TEST(SlamPipeline, SaysThatItIsLostWhenWhatItKnowsIsNotThere) {
  PipelineOptions options = wide_open();
  options.association.type = AssociationOptions::Type::kNearestNeighbor;
  options.life_cycle.confirm_sightings = 5;
  options.life_cycle.confirm_motion = 0.0;
  options.life_cycle.confirm_time = 3.0;
  options.life_cycle.remove_after_visits = 4;
  options.life_cycle.field_of_view_deg = 360.0;
  options.life_cycle.view_range = 10.0;
  const auto pipeline = make_pipeline(options);
  const auto look = [&](double seconds, double aside) {
    std::vector<Detection> detections;
    for (const Eigen::Vector2d& place : kCylinders) {
      detections.push_back(detection(place.x() + aside, place.y() + aside, kNoId, 0.02));
    }
    return pipeline->process(detection_frame(seconds, detections)).localization;
  };
  for (int i = 0; i < 50; ++i) EXPECT_EQ(look(0.1 * i, 0.0), Localization::kTracking);
  bool is_lost = false;
  for (int i = 50; i < 80 && !is_lost; ++i) is_lost = look(0.1 * i, 0.7) == Localization::kLost;
  EXPECT_TRUE(is_lost);
}

TEST(SlamPipeline, LooksForTheRobotOnlyInAMapThatStays) {
  const auto pipeline = make_pipeline(wide_open());
  EXPECT_THROW(pipeline->relocalize(), std::invalid_argument);
  pipeline->set_mode(Mode::kLocalization);
  EXPECT_THROW(pipeline->relocalize(), std::invalid_argument) << "there is no map";
}

TEST(SlamPipeline, LiveOptionsTakeEffectAndKeepTheEstimate) {
  PipelineOptions options = wide_open();
  const auto pipeline = make_pipeline(options);
  pipeline->process(detection_frame(1.0, {detection(2.0, 0.0, 1)}));
  options.input.max_linear_speed = 0.1;
  options.sensor.max_depth = 1.0;
  pipeline->set_live_options(options);
  EXPECT_EQ(pipeline->map().size(), 1U);
  EXPECT_EQ(pipeline->process(detection_frame(1.1, {detection(2.0, 0.0, 1)})).outcomes[0].verdict,
            Verdict::kOutOfRange);
  pipeline->process(odometry_frame(2.0, 1.0));
  EXPECT_NEAR(x_of(pipeline->process(odometry_frame(3.0, 1.0))), 0.1, 1e-9);
}

TEST(SlamPipeline, SaysThatTheFloorIsNotExactlyFlat) {
  const Pose3d pose = make_pipeline(wide_open())->process(odometry_frame(1.0, 0.0)).pose;
  for (const int axis : {2, 3, 4}) EXPECT_EQ(pose.covariance(axis, axis), kPlanarVariance);
}

}  // namespace
}  // namespace kinect_ekf_slam
