#include "kinect_ekf_slam/pipeline/global_mapper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/frames.h"

namespace kinect_ekf_slam {
namespace {

using testing::odometry_frame;

/// A robot that drives a curve through an empty place at 1 m/s; only something else tells where it is.
class GlobalMapperDrive : public ::testing::Test {
 protected:
  PipelineOptions options_ = testing::wide_open();
  std::unique_ptr<GlobalMapper> mapper_;
  std::vector<std::pair<double, Se2>> truth_;
  RandomStream random_{3, 0};

  /// `tell` adds to a frame what is known each second.
  template <class Tell>
  GlobalMap3d drive(int seconds, const Tell& tell) {
    if (!mapper_) mapper_ = make_global_mapper(options_);
    constexpr double kPeriod = 0.1;  // s
    Se2 pose;
    for (int i = 0; i <= 10 * seconds; ++i) {
      const double time = 1.0 + kPeriod * i;
      truth_.emplace_back(time, pose);
      SensorFrame frame = odometry_frame(time, 1.0, 0.2);
      if (i % 10 == 5) tell(pose, &frame);
      mapper_->add(frame);
      pose = pose * Se2::exp({kPeriod, 0.0, 0.2 * kPeriod});
    }
    return mapper_->integration()();
  }
  GlobalPosition position_at(const Eigen::Vector3d& place, double sigma) {
    GlobalPosition position;
    position.position_in_map = place + sigma * Eigen::Vector3d(random_.normal(), random_.normal(), 0.0);
    position.covariance.diagonal().setConstant(sigma * sigma);
    return position;
  }
  /// m, RMS; the truth in the global frame is `global_from_start` times that of the drive.
  double path_error(const GlobalMap3d& map, const Se2& global_from_start = Se2()) const {
    double squares = 0.0;
    double count = 0.0;
    for (const auto& segment : map.segments) {
      for (const Pose3d& pose : segment.path) {
        const auto i = static_cast<std::size_t>(std::lround(10.0 * (to_seconds(pose.stamp) - 1.0)));
        const Eigen::Vector2d expected = (global_from_start * truth_[i].second).translation();
        squares += (pose.map_from_base.translation().head<2>() - expected).squaredNorm();
        count += 1.0;
      }
    }
    return std::sqrt(squares / count);
  }
};

TEST_F(GlobalMapperDrive, PlacesTheWayByPositionsInTheirFrame) {
  const Se2 global_from_start(100.0, -50.0, 2.0);
  const GlobalMap3d map = drive(60, [&](const Se2& pose, SensorFrame* frame) {
    frame->global_position = position_at(Planar::to_3d((global_from_start * pose).translation()), 0.2);
  });
  EXPECT_FALSE(map.positions_in_map);
  EXPECT_EQ(map.positions.size(), 60U);
  ASSERT_FALSE(map.segments.empty());
  for (const auto& segment : map.segments) EXPECT_EQ(segment.refusal, "");
  EXPECT_LT(path_error(map, global_from_start), 0.15);
}

/// The beacons stand higher than the receiver, which is beside the robot's centre.
TEST_F(GlobalMapperDrive, PlacesTheWayByRangesToBeacons) {
  options_.positions.beacons = {{1, {-5.0, -5.0, 3.0}, 0.05},
                                {2, {12.0, -4.0, 3.0}, 0.05},
                                {3, {10.0, 14.0, 3.0}, 0.05},
                                {4, {-6.0, 12.0, 3.0}, 0.05},
                                {5, {0.0, 20.0, 3.0}, 2.0}};  // hardly known: it tells no place
  const Eigen::Vector3d receiver(0.3, 0.2, 0.5);
  const GlobalMap3d map = drive(60, [&](const Se2& pose, SensorFrame* frame) {
    for (const Beacon& beacon : options_.positions.beacons) {
      BeaconRange range;
      range.beacon = beacon.id;
      range.receiver_in_base = receiver;
      const Eigen::Vector3d at = Planar::to_3d(pose) * receiver;
      const double wrong = beacon.id == 5 ? 2.0 : 0.0;
      range.range = (beacon.position_in_map - at).norm() + 0.1 * random_.normal() + wrong;
      range.variance = 0.01;
      frame->ranges.push_back(range);
    }
  });
  EXPECT_TRUE(map.positions_in_map);
  EXPECT_GT(map.positions.size(), 50U);
  ASSERT_FALSE(map.segments.empty());
  for (const auto& segment : map.segments) EXPECT_EQ(segment.refusal, "");
  EXPECT_LT(path_error(map), 0.12);
}

TEST_F(GlobalMapperDrive, TakesPositionsOfOneFrameOnly) {
  int told = 0;
  const GlobalMap3d map = drive(30, [&](const Se2& pose, SensorFrame* frame) {
    auto& position = told++ % 3 == 0 ? frame->position : frame->global_position;
    position = position_at(Planar::to_3d(pose.translation()), 0.2);
  });
  EXPECT_TRUE(map.positions_in_map);
  EXPECT_EQ(map.positions.size(), 10U);
  EXPECT_EQ(map.ignored, 20U);
}

TEST_F(GlobalMapperDrive, UsesNeitherWhatIsWithheldNorWhatIsNoPosition) {
  options_.positions.withheld = {{0.0, 10.0}};
  int told = 0;
  const GlobalMap3d map = drive(30, [&](const Se2& pose, SensorFrame* frame) {
    frame->position = position_at(Planar::to_3d(pose.translation()), 0.2);
    if (++told > 20) frame->position->covariance.setZero();
  });
  EXPECT_EQ(map.positions.size(), 10U);
}

TEST_F(GlobalMapperDrive, BreaksThePathWhereTheRobotWasCarried) {
  const auto tell = [&](const Se2& pose, SensorFrame* frame) {
    frame->position = position_at(Planar::to_3d(pose.translation()), 0.1);
  };
  options_.global_mapping.local_maps.max_position_sigma = 1e3;
  options_.global_mapping.local_maps.max_turn_sigma_deg = 1e3;
  EXPECT_EQ(drive(20, tell).segments.size(), 1U);
  mapper_->break_path();
  SensorFrame frame = odometry_frame(30.0, 1.0, 0.2);
  mapper_->add(frame);
  mapper_->add(odometry_frame(31.0, 1.0, 0.2));
  EXPECT_EQ(mapper_->integration()().segments.size(), 2U);
}

TEST_F(GlobalMapperDrive, HasNoWayBeforeTheFirstFrame) {
  const GlobalMap3d map = make_global_mapper(options_)->integration()();
  EXPECT_TRUE(map.segments.empty());
  EXPECT_TRUE(map.landmarks.empty());
}

TEST(GlobalMapper, IsNotMadeWithoutAKalmanFilter) {
  PipelineOptions options;
  options.estimator.type = EstimatorOptions::Type::kFastSlam1;
  EXPECT_THROW(make_global_mapper(options), std::invalid_argument);
}

}  // namespace
}  // namespace kinect_ekf_slam
