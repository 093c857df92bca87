/// What the pipeline does in space that it cannot do in the plane.
#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/pipeline/slam_pipeline.h"
#include "test/support/frames.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::detection;
using testing::detection_frame;
using testing::MatrixNear;
using testing::odometry_frame;
using testing::wide_open;

PipelineOptions spatial() {
  PipelineOptions options = wide_open();
  options.space = SpaceType::kSpatial;
  return options;
}

Detection detection_at(const Eigen::Vector3d& position_in_base, int identity) {
  Detection seen = detection(position_in_base.x(), position_in_base.y(), identity);
  seen.position_in_base = position_in_base;
  return seen;
}

SensorFrame gyro_frame(double time, const Eigen::Vector3d& rate) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.gyro_rate = rate;
  return frame;
}

TEST(SpatialPipeline, StartsWhereTheOptionsSay) {
  PipelineOptions options = spatial();
  InitialPoseOptions& start = options.initial_pose;
  start.x = 1.0;
  start.z = 3.0;
  start.pitch_deg = -90.0;  // it looks up
  start.yaw_deg = 90.0;
  start.position_sigma = 0.2;
  start.heading_sigma_deg = 3.0;
  const Pose3d pose = make_pipeline(options)->process(odometry_frame(1.0, 0.0)).pose;
  EXPECT_TRUE(MatrixNear(pose.map_from_base.translation(), Eigen::Vector3d(1.0, 0.0, 3.0), 1e-12));
  EXPECT_TRUE(
      MatrixNear(pose.map_from_base.linear() * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), 1e-12));
  for (int axis = 0; axis < 6; ++axis) {
    EXPECT_NEAR(pose.covariance(axis, axis), std::pow(axis < 3 ? 0.2 : radians(3.0), 2), 1e-12) << axis;
  }
}

/// Forward speed from the odometry, which knows nothing of pitch; three rates from the gyro: half a loop.
TEST(SpatialPipeline, FliesWithTheGyrosThreeRates) {
  PipelineOptions options = spatial();
  options.input.heading_source = HeadingSource::kImu;
  const auto pipeline = make_pipeline(options);
  const double radius = 0.5;
  const double rate = 0.5;
  SlamResult result;
  for (int i = 0; i <= 100; ++i) {
    const double time = 1.0 + i * kPi / rate / 100.0;
    result = pipeline->process(odometry_frame(time, radius * rate));
    pipeline->process(gyro_frame(time, {0.0, -rate, 0.0}));
  }
  const Eigen::Isometry3d& pose = result.pose.map_from_base;
  EXPECT_TRUE(MatrixNear(pose.translation(), Eigen::Vector3d(0.0, 0.0, 2.0 * radius), 1e-9));
  EXPECT_TRUE(MatrixNear(pose.linear() * Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitX(), 1e-9));
}

/// REP-103: rotations about the map's axes. A robot that heads along y and is unsure of its roll is unsure
/// about the map's y axis.
TEST(SpatialPipeline, ThePosesCovarianceStandsInTheMapsAxes) {
  PipelineOptions options = spatial();
  options.input.heading_source = HeadingSource::kImu;
  options.initial_pose.yaw_deg = 90.0;
  options.initial_pose.heading_sigma_deg = 1e-6;
  options.motion.gyro_noise = 0.0;
  options.motion.gyro_noise_per_rate = 0.0;
  options.motion.angular_noise_per_speed = 0.0;
  const auto pipeline = make_pipeline(options);
  pipeline->process(odometry_frame(1.0, 0.5));
  Pose3d unsure = pipeline->look_ahead({}, to_nanoseconds(1.0));
  unsure.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-6, 0.01, 1e-6;  // about the map's y: the robot's roll
  pipeline->set_pose(unsure);
  // A landmark ahead tells nothing of the roll, one aside does: up and down are what a roll moves it.
  const SlamResult ahead = pipeline->process(detection_frame(1.0, {detection_at({2.0, 0.0, 0.0}, 1)}));
  EXPECT_NEAR(ahead.pose.covariance(4, 4), 0.01, 1e-9);
  pipeline->process(detection_frame(1.0, {detection_at({0.0, 2.0, 0.0}, 2)}));
  const std::vector<Landmark3d> map = pipeline->map();
  ASSERT_EQ(map.size(), 2U);
  const double aside_z = map[1].covariance(2, 2);
  EXPECT_NEAR(aside_z, 0.05 * 0.05 + 0.01 * 2.0 * 2.0, 1e-4) << "lever arm of the roll";
  EXPECT_NEAR(map[0].covariance(2, 2), 0.05 * 0.05, 1e-4);
}

TEST(SpatialPipeline, MapsLandmarksAtTheirHeights) {
  const auto pipeline = make_pipeline(spatial());
  const std::vector<Detection> seen = {detection_at({2.0, 0.5, 0.7}, 1), detection_at({1.5, -0.5, -0.4}, 2),
                                       detection_at({2.5, 0.0, 0.1}, 3)};
  pipeline->process(detection_frame(1.0, seen));
  const SlamResult again = pipeline->process(detection_frame(1.1, seen));
  EXPECT_EQ(again.dof, 9);
  const std::vector<Landmark3d> map = pipeline->map();
  ASSERT_EQ(map.size(), 3U);
  for (std::size_t i = 0; i < map.size(); ++i) {
    EXPECT_TRUE(MatrixNear(map[i].position_in_map, seen[i].position_in_base, 1e-9));
    EXPECT_GT(map[i].covariance.determinant(), 0.0);
  }
}

TEST(SpatialPipeline, SavesAndLoads) {
  const auto first = make_pipeline(spatial());
  first->process(odometry_frame(1.0, 0.5));
  first->process(detection_frame(1.5, {detection_at({2.0, 0.0, 1.0}, 1), detection_at({1.0, 1.0, -1.0}, 2)}));
  const SavedState saved = first->save();
  EXPECT_EQ(saved.space, "spatial");
  EXPECT_EQ(saved.landmarks_in_map.cols(), 3);
  EXPECT_EQ(saved.covariance.rows(), 12);
  const auto second = make_pipeline(spatial());
  second->load(saved, true);
  const SavedState again = second->save();
  EXPECT_TRUE(MatrixNear(again.pose, saved.pose, 1e-15));
  EXPECT_TRUE(MatrixNear(again.landmarks_in_map, saved.landmarks_in_map, 0.0));
  EXPECT_TRUE(MatrixNear(again.covariance, saved.covariance, 0.0));
  EXPECT_THROW(make_pipeline(wide_open())->load(saved, true), std::invalid_argument);
}

/// On a floor the spatial estimate is the planar one, as far as the plane goes.
TEST(SpatialPipeline, AgreesWithThePlanarOneOnTheFloor) {
  const auto in_space = make_pipeline(spatial());
  const auto in_plane = make_pipeline(wide_open());
  for (SlamPipeline* pipeline : {in_space.get(), in_plane.get()}) {
    pipeline->process(odometry_frame(1.0, 0.4, 0.3));
    pipeline->process(detection_frame(1.0, {detection(2.0, 0.5, 1), detection(2.0, -1.0, 2)}));
    pipeline->process(detection_frame(1.5, {detection(1.85, 0.2, 1), detection(1.65, -1.2, 2)}));
  }
  const Pose3d a = in_space->look_ahead({}, to_nanoseconds(1.5));
  const Pose3d b = in_plane->look_ahead({}, to_nanoseconds(1.5));
  EXPECT_TRUE(MatrixNear(a.map_from_base.matrix(), b.map_from_base.matrix(), 1e-3));
}

}  // namespace
}  // namespace kinect_ekf_slam
