/// Positions and ranges through the pipeline: alignment, outliers, delays, beacons.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/frames.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::odometry_frame;

constexpr double kPeriod = 0.1;  // s

PipelineOptions options(EstimatorOptions::Type type = EstimatorOptions::Type::kInvariantEkf) {
  PipelineOptions options = testing::wide_open();
  options.estimator.type = type;
  return options;
}

GlobalPosition position_at(const Eigen::Vector3d& place, double sigma) {
  GlobalPosition position;
  position.position_in_map = place;
  position.covariance.diagonal().setConstant(sigma * sigma);
  return position;
}

SensorFrame position_frame(double time, const GlobalPosition& position) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.position = position;
  return frame;
}

SensorFrame range_frame(double time, const std::vector<BeaconRange>& ranges) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.ranges = ranges;
  return frame;
}

/// Drives a curve at 1 m/s; positions come each second, perhaps with a shift.
class Drive {
 public:
  explicit Drive(const PipelineOptions& options) : pipeline_(make_pipeline(options)) {}

  /// Seconds, and what is added to the positions; the last result.
  SlamResult run(int seconds, const Eigen::Vector3d& shift = Eigen::Vector3d::Zero()) {
    SlamResult result;
    for (int second = 0; second < seconds; ++second) {
      for (int i = 0; i < 10; ++i) drive();
      const Eigen::Vector3d noise(0.5 * random_.normal(), 0.5 * random_.normal(), 0.0);
      result = pipeline_->process(position_frame(time_, position_at(truth() + noise + shift, 0.5)));
    }
    return result;
  }
  void drive() {
    pipeline_->process(odometry_frame(time_, 1.0, 0.1));
    pose_ = pose_ * Se2::exp({kPeriod, 0.0, 0.1 * kPeriod});
    time_ += kPeriod;
  }
  Eigen::Vector3d truth() const { return Planar::to_3d(pose_.translation()); }
  Eigen::Vector3d estimate() const {
    return pipeline_->look_ahead({}, to_nanoseconds(time_)).map_from_base.translation();
  }
  double time() const { return time_; }
  SlamPipeline& pipeline() { return *pipeline_; }
  RandomStream& random() { return random_; }

 private:
  std::unique_ptr<SlamPipeline> pipeline_;
  Se2 pose_;
  double time_ = 1.0;
  RandomStream random_{3, 0};
};

TEST(Positions, CorrectTheEstimate) {
  PipelineOptions off = options();
  off.initial_pose.x = 2.0;
  off.initial_pose.position_sigma = 2.0;
  Drive drive(off);
  const SlamResult result = drive.run(30);
  ASSERT_EQ(result.positions.size(), 1U);
  EXPECT_EQ(result.positions[0].verdict, PositionVerdict::kUsed);
  EXPECT_LT((drive.estimate() - drive.truth()).norm(), 0.5);
}

TEST(Positions, AJumpOfTwentyMetresBendsNothing) {
  Drive drive(options());
  drive.run(60);
  for (int i = 0; i < 10; ++i) drive.drive();
  const Eigen::Vector3d before = drive.estimate();
  const auto result = drive.pipeline().process(
      position_frame(drive.time(), position_at(drive.truth() + Eigen::Vector3d(20.0, 0.0, 0.0), 0.5)));
  EXPECT_EQ(result.positions[0].verdict, PositionVerdict::kOutsideGate);
  EXPECT_EQ(result.localization, Localization::kTracking);
  EXPECT_TRUE(testing::MatrixNear(drive.estimate(), before, 1e-12));
}

/// Positions whose errors last weigh little each, but none errs by more than it says.
TEST(Positions, AJumpIsRefusedHoweverLittleItWeighs) {
  PipelineOptions lasting = options();
  lasting.positions.correlation_time = 100.0;
  Drive drive(lasting);
  drive.run(60);
  EXPECT_EQ(drive.run(1, {20.0, 0.0, 0.0}).positions[0].verdict, PositionVerdict::kOutsideGate);
  EXPECT_EQ(drive.run(1).positions[0].verdict, PositionVerdict::kUsed);
}

TEST(Positions, JumpsThatDisagreeAreOutliersHoweverManyThereAre) {
  Drive drive(options());
  drive.run(20);
  for (int i = 0; i < 60; ++i) {
    const double direction = drive.random().uniform(-kPi, kPi);
    const auto result = drive.run(1, 30.0 * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0));
    EXPECT_EQ(result.positions[0].verdict, PositionVerdict::kOutsideGate);
    EXPECT_EQ(result.localization, Localization::kTracking);
  }
  EXPECT_LT((drive.estimate() - drive.truth()).norm(), 2.0);
}

/// Carried away: after lost_after it is said, and the estimate comes to where the positions are.
TEST(Positions, ThatAgreeForLongShowThatTheEstimateIsWrong) {
  Drive drive(options());
  drive.run(20);
  const Eigen::Vector3d carried(30.0, -10.0, 0.0);
  EXPECT_EQ(drive.run(9, carried).localization, Localization::kTracking);
  EXPECT_EQ(drive.run(3, carried).localization, Localization::kLost);
  EXPECT_EQ(drive.run(20, carried).localization, Localization::kTracking);
  EXPECT_LT((drive.estimate() - drive.truth() - carried).norm(), 1.5);
}

TEST(Positions, ThatAreOlderThanTheEstimateAreLate) {
  Drive drive(options());
  drive.run(5);
  const auto result = drive.pipeline().process(position_frame(2.0, position_at(drive.truth(), 0.5)));
  EXPECT_EQ(result.positions[0].verdict, PositionVerdict::kLate);
}

TEST(Positions, ThatAreWithheldAreToldButNotUsed) {
  PipelineOptions withheld = options();
  withheld.positions.withheld = {{2.0, 4.0}};
  Drive drive(withheld);
  EXPECT_EQ(drive.run(1).positions[0].verdict, PositionVerdict::kUsed);
  const auto result = drive.run(2);
  EXPECT_EQ(result.positions[0].verdict, PositionVerdict::kWithheld);
  EXPECT_LT((result.positions[0].position_in_map - drive.truth()).norm(), 3.0);
  EXPECT_EQ(drive.run(2).positions[0].verdict, PositionVerdict::kUsed);
}

TEST(Positions, OfNoUseAreInvalid) {
  Drive drive(options());
  GlobalPosition nowhere = position_at({0.0, std::nan(""), 0.0}, 0.5);
  EXPECT_EQ(drive.pipeline().process(position_frame(1.0, nowhere)).positions[0].verdict,
            PositionVerdict::kInvalid);
  GlobalPosition sure = position_at(Eigen::Vector3d::Zero(), 0.0);
  EXPECT_EQ(drive.pipeline().process(position_frame(1.0, sure)).positions[0].verdict,
            PositionVerdict::kInvalid);
}

TEST(Positions, AreNotUsedByAnEstimatorThatIsNoKalmanFilter) {
  Drive drive(options(EstimatorOptions::Type::kDeadReckoning));
  EXPECT_EQ(drive.run(2).positions[0].verdict, PositionVerdict::kUnsupported);
}

/// A robot that is told global positions knows neither where it starts nor which way it looks. Its motion is
/// exact here: what is uncertain is the alignment, and what comes after it.
TEST(Alignment, SaysHowSurelyTheRobotIsWhereItIs) {
  constexpr int kSeeds = 60;
  double nees = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    RandomStream random(static_cast<std::uint64_t>(seed), 0);
    PipelineOptions exact = options(EstimatorOptions::Type::kEkf);
    exact.estimator.robust_threshold = 0.0;
    exact.positions.gate_probability = 1.0;
    exact.motion = {};
    for (double* noise : {&exact.motion.linear_noise, &exact.motion.linear_noise_per_speed,
                          &exact.motion.lateral_noise_per_speed, &exact.motion.angular_noise,
                          &exact.motion.angular_noise_per_rate, &exact.motion.angular_noise_per_speed}) {
      *noise = 1e-4;
    }
    const auto pipeline = make_pipeline(exact);
    const Se2 global_from_map(random.uniform(-1e5, 1e5), random.uniform(-1e5, 1e5),
                              random.uniform(-kPi, kPi));
    Se2 map_from_base;
    SlamResult result;
    double time = 1.0;
    int used = 0;
    for (; used < 5 && time < 100.0; time += 1.0) {
      for (int i = 0; i < 10; ++i) pipeline->process(odometry_frame(time + i * kPeriod, 1.0, 0.05));
      map_from_base = map_from_base * Se2::exp({1.0, 0.0, 0.05});
      SensorFrame frame;
      frame.stamp = to_nanoseconds(time + 1.0);
      frame.global_position = position_at(Planar::to_3d((global_from_map * map_from_base).translation()) +
                                              Eigen::Vector3d(random.normal(), random.normal(), 0.0),
                                          1.0);
      result = pipeline->process(frame);
      const PositionVerdict verdict = result.positions[0].verdict;
      if (verdict == PositionVerdict::kUsed) ++used;
    }
    ASSERT_EQ(used, 5) << "seed " << seed;
    // Where the robot really is in the map, which lies where it was found to lie.
    const Se2 truth =
        Planar::pose_from_3d(*result.map_from_global * Planar::to_3d(global_from_map * map_from_base));
    const auto estimate = to_estimate<Planar>(result.pose);
    const Eigen::Vector3d error = pose_error<Planar>(estimate.map_from_base, truth);
    nees += error.dot(estimate.covariance.llt().solve(error));
  }
  EXPECT_GT(nees, chi_square_quantile(0.001, 3 * kSeeds));
  EXPECT_LT(nees, chi_square_quantile(0.999, 3 * kSeeds));
}

TEST(Alignment, WaitsWhileTheRobotStands) {
  const auto pipeline = make_pipeline(options());
  RandomStream random(1, 0);
  for (int i = 0; i < 300; ++i) {
    pipeline->process(odometry_frame(i, 0.0));
    SensorFrame frame;
    frame.stamp = to_nanoseconds(i + 0.5);
    frame.global_position = position_at({random.normal(), random.normal(), 0.0}, 1.0);
    const auto result = pipeline->process(frame);
    ASSERT_EQ(result.positions[0].verdict, PositionVerdict::kAligning);
    ASSERT_FALSE(result.map_from_global);
  }
}

TEST(Alignment, IsNotBentByAFewJumps) {
  const auto pipeline = make_pipeline(options());
  RandomStream random(1, 0);
  Se2 map_from_base;
  SlamResult result;
  for (int second = 1; second <= 40; ++second) {
    pipeline->process(odometry_frame(second, 1.0));
    map_from_base = map_from_base * Se2::exp({1.0, 0.0, 0.0});
    SensorFrame frame;
    frame.stamp = to_nanoseconds(second + 1.0);
    Eigen::Vector3d place = Planar::to_3d(map_from_base.translation());
    place += Eigen::Vector3d(random.normal(), random.normal(), 0.0);
    if (second % 9 == 5) place.x() += 20.0;
    frame.global_position = position_at(place, 1.0);
    result = pipeline->process(frame);
  }
  ASSERT_TRUE(result.map_from_global);
  EXPECT_LT(result.map_from_global->translation().norm(), 3.0);
}

/// The source's buoys: no landmark, odometry and ranges alone.
TEST(Beacons, TellWhereTheRobotIs) {
  PipelineOptions with_beacons = options();
  with_beacons.initial_pose.position_sigma = 1.0;
  with_beacons.initial_pose.x = 0.8;
  with_beacons.positions.beacons = {
      {4, {-20.0, 5.0, 2.0}, 0.05}, {7, {15.0, 25.0, 3.0}, 0.05}, {9, {10.0, -15.0, 2.0}, 3.0}};
  Drive drive(with_beacons);
  SlamResult result;
  const Eigen::Vector3d really(11.0, -17.0, 2.0);  // beacon 9 is known to 3 m only
  for (int second = 0; second < 60; ++second) {
    for (int i = 0; i < 10; ++i) drive.drive();
    std::vector<BeaconRange> ranges;
    for (const auto& [id, place] : std::map<int, Eigen::Vector3d>{
             {4, {-20.0, 5.0, 2.0}}, {7, {15.0, 25.0, 3.0}}, {9, really}, {11, {0.0, 1.0, 0.0}}}) {
      const double range = (place - drive.truth() - Eigen::Vector3d(0.0, 0.0, 0.5)).norm();
      ranges.push_back({id, range + 0.1 * drive.random().normal(), 0.01, {0.0, 0.0, 0.5}});
    }
    result = drive.pipeline().process(range_frame(drive.time(), ranges));
  }
  ASSERT_EQ(result.positions.size(), 4U);
  EXPECT_EQ(result.positions[0].verdict, PositionVerdict::kUsed);
  EXPECT_EQ(result.positions[3].verdict, PositionVerdict::kUnknownBeacon);
  EXPECT_LT((drive.estimate() - drive.truth()).norm(), 0.3);
  EXPECT_TRUE(drive.pipeline().map().empty());
  const auto beacons = drive.pipeline().beacons();
  ASSERT_EQ(beacons.size(), 3U);
  EXPECT_EQ(beacons[2].id, 9);
  EXPECT_LT((beacons[2].position_in_map - really).norm(), 0.5);
}

TEST(Beacons, AreInASavedMapAsTheyWereFound) {
  PipelineOptions with_beacon = options();
  with_beacon.positions.beacons = {{4, {5.0, 0.0, 0.0}, 1.0}};
  const auto pipeline = make_pipeline(with_beacon);
  pipeline->process(odometry_frame(1.0, 0.0));
  pipeline->process(range_frame(1.0, {{4, 6.0, 1e-4, Eigen::Vector3d::Zero()}}));
  const auto again = make_pipeline(with_beacon);
  again->load(pipeline->save(), true);
  ASSERT_EQ(again->beacons().size(), 1U);
  EXPECT_GT(again->beacons()[0].position_in_map.x(), 5.8);
  EXPECT_EQ(again->beacons()[0].position_in_map, pipeline->beacons()[0].position_in_map);
}

}  // namespace
}  // namespace kinect_ekf_slam
