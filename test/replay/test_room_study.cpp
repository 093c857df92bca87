#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/pipeline/slam_pipeline.h"
#include "kinect_ekf_slam/ros/configuration.h"
#include "kinect_ekf_slam/ros/picture_detector.h"
#include "kinect_ekf_slam/simulation/evaluation.h"
#include "kinect_ekf_slam/study/room_study.h"

namespace kinect_ekf_slam {
namespace {

RoomSummary study(const std::string& world, int seeds, const std::vector<std::string>& settings) {
  const auto folder = std::filesystem::path(__FILE__).parent_path() / "../../config/worlds";
  RoomStudy study;
  study.world = read_world((folder / world).string());
  study.seeds = seeds;
  study.pipeline = read_run_options({}, settings, [](const std::string& line) { FAIL() << line; }).pipeline;
  return summarize(run_study(study));
}

/// The report's conditions with the defaults: a Kinect whose single sightings are 3 to 10 cm off, ten
/// cylinders.
TEST(RoomStudy, TheDefaultsMapTheRoomToFiveCentimetres) {
  const RoomSummary summary = study("room.yaml", 50, {});
  EXPECT_LE(summary.landmark_rmse_aligned.mean, 0.05);
  EXPECT_LE(summary.landmark_rmse_aligned.worst, 0.09);
  EXPECT_EQ(summary.exact_count_share, 1.0) << "every landmark once and nothing else";
  EXPECT_LE(summary.nees.mean, 3.5) << "not surer of the pose than it may be";
}

TEST(RoomStudy, EveryLandmarkIsFoundWithAPoorDetector) {
  const RoomSummary summary = study("room_hard.yaml", 50, {});
  EXPECT_GE(summary.exact_count_share, 0.98);
  EXPECT_EQ(summary.silent_failures, 0U);
  EXPECT_EQ(summary.missed.worst, 0.0);
  EXPECT_LE(summary.landmark_rmse_aligned.mean, 0.05);
  EXPECT_LE(summary.landmark_rmse_aligned.worst, 0.09);
}

/// What a burst of bad sightings does to one look.
using Burst = std::function<void(double seconds, std::vector<Detection>* detections)>;

struct BurstRun {
  MapComparison map;
  Eigen::Vector3d end_in_map;
};

BurstRun run_with(const Burst& burst, std::uint64_t seed) {
  const auto folder = std::filesystem::path(__FILE__).parent_path() / "../../config/worlds";
  const World world = read_world((folder / "room.yaml").string());
  Simulator simulator(world, seed);
  const auto pipeline = make_pipeline(read_run_options({}, {}, [](const std::string&) {}).pipeline);
  SlamResult result;
  while (!simulator.finished()) {
    SensorFrame frame = to_sensor_frame(simulator.next(), world);
    if (frame.detections) burst(to_seconds(frame.stamp), &*frame.detections);
    result = pipeline->process(frame);
  }
  const Eigen::Isometry3d start_from_world = world.drive.world_from_start.to_3d().inverse();
  Points<Planar> truth;
  Points<Planar> estimate;
  for (const WorldLandmark& landmark : world.landmarks) {
    truth.push_back(Planar::from_3d(start_from_world * landmark.position_in_world));
  }
  for (const Landmark3d& landmark : pipeline->map()) {
    if (landmark.confirmed) estimate.push_back(Planar::from_3d(landmark.position_in_map));
  }
  return {compare_maps<Planar>(truth, estimate), result.pose.map_from_base.translation()};
}

/// The bursts neither enter the map nor move the pose by more than the landmarks' own noise does.
void expect_harmless(const Burst& burst) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const BurstRun clean = run_with([](double, std::vector<Detection>*) {}, seed);
    const BurstRun bad = run_with(burst, seed);
    EXPECT_EQ(bad.map.estimated_landmarks, bad.map.true_landmarks) << seed;
    EXPECT_EQ(bad.map.matched, bad.map.true_landmarks) << seed;
    EXPECT_LE(bad.map.rmse_aligned, 0.05) << seed;
    EXPECT_LE((bad.end_in_map - clean.end_in_map).norm(), 0.05) << seed;
  }
}

TEST(RoomStudy, APersonWhoWalksByStaysOutOfTheMap) {
  expect_harmless([](double seconds, std::vector<Detection>* detections) {
    for (const double start : {10.0, 35.0, 70.0}) {
      const double since = seconds - start;
      if (since < 0.0 || since > 2.0) continue;
      Detection person;
      person.position_in_base = {1.6, 0.8 - 0.8 * since, 0.25};  // m; walks across the view
      person.position_in_optical = {-person.position_in_base.y(), 0.0, 1.5};
      detections->push_back(person);
    }
  });
}

TEST(RoomStudy, AReflectionThatLastsDoesNotBendTheMap) {
  expect_harmless([](double seconds, std::vector<Detection>* detections) {
    for (const double start : {12.0, 40.0, 75.0}) {
      if (seconds < start || seconds > start + 2.0) continue;
      for (Detection& detection : *detections) {
        const Eigen::Vector3d away = 0.5 * detection.position_in_base.normalized();  // m; all too far
        detection.position_in_base += away;
        detection.position_in_optical.z() += away.norm();
      }
    }
  });
}

/// What is seen a second time, `apart` (m, ahead and to the left) from the first.
void see_double(const Eigen::Vector2d& apart, std::vector<Detection>* detections) {
  const std::vector<Detection> seen = *detections;
  for (Detection twin : seen) {
    twin.position_in_base.head<2>() += apart;
    twin.position_in_optical += Eigen::Vector3d(-apart.y(), 0.0, apart.x());
    detections->push_back(twin);
  }
}

TEST(RoomStudy, ADetectorThatNowAndThenSeesTwoWhereThereIsOneMapsOne) {
  for (const Eigen::Vector2d& apart : {Eigen::Vector2d(0.0, 0.25), Eigen::Vector2d(0.15, 0.0)}) {
    SCOPED_TRACE(apart.transpose());
    int look = 0;
    expect_harmless([&](double, std::vector<Detection>* detections) {
      if (++look % 10 == 0) see_double(apart, detections);
    });
    expect_harmless([&](double seconds, std::vector<Detection>* detections) {
      for (const double start : {12.0, 40.0, 75.0}) {
        if (seconds >= start && seconds <= start + 2.0) see_double(apart, detections);
      }
    });
  }
}

TEST(RoomStudy, TheMapIsBetterThanDeadReckonings) {
  const RoomSummary slam = study("room.yaml", 20, {});
  const RoomSummary open_loop = study("room.yaml", 20, {"estimator/type=dead_reckoning"});
  EXPECT_LT(2.0 * slam.landmark_rmse_aligned.mean, open_loop.landmark_rmse_aligned.mean);
  EXPECT_LT(2.0 * slam.path_rmse.mean, open_loop.path_rmse.mean);
}

/// Three coordinates each, seen from a robot that climbs, dives and banks.
TEST(RoomStudy, InSpaceTheLandmarksAreFoundToFiveCentimetres) {
  for (const char* type : {"ekf", "invariant_ekf", "ukf"}) {
    const RoomSummary summary =
        study("room_3d.yaml", 20, {"estimator/space=spatial", std::string("estimator/type=") + type});
    EXPECT_EQ(summary.pose_dof, 6);
    EXPECT_EQ(summary.exact_count_share, 1.0) << type;
    EXPECT_LE(summary.landmark_rmse_aligned.mean, 0.03) << type;
    EXPECT_LE(summary.landmark_rmse_aligned.worst, 0.05) << type;
    EXPECT_LE(summary.nees.mean, summary.nees_high) << type << ": not surer of the pose than it may be";
  }
}

/// A robot on the floor, estimated as if it could fly: the floor is found to be flat.
TEST(RoomStudy, InSpaceTheFloorIsFlat) {
  const RoomSummary summary = study("room.yaml", 20, {"estimator/space=spatial"});
  EXPECT_EQ(summary.exact_count_share, 1.0);
  EXPECT_LE(summary.landmark_rmse_aligned.mean, 0.05);
}

TEST(RoomStudy, TheSameSeedsGiveTheSameFigures) {
  const RoomSummary first = study("room.yaml", 4, {});
  const RoomSummary second = study("room.yaml", 4, {});
  EXPECT_EQ(first.landmark_rmse_aligned.mean, second.landmark_rmse_aligned.mean);
  EXPECT_EQ(first.nees.worst, second.nees.worst);
}

std::string config(const std::string& name) {
  return (std::filesystem::path(__FILE__).parent_path() / "../../config" / name).string();
}

/// One run that sees what a detector finds in rendered pictures.
RoomSummary chain(const World& world, const DetectorOptions& detector,
                  const std::vector<std::string>& configs) {
  RoomStudy study;
  study.world = world;
  study.seeds = 1;
  study.pipeline = read_run_options(configs, {}, [](const std::string& line) { FAIL() << line; }).pipeline;
  study.make_detector = [&] {
    const auto eyes = std::make_shared<PictureDetector>(detector);
    return
        [eyes](const RgbdPicture& picture, const Eigen::Vector3d& up) { return eyes->detect(picture, up); };
  };
  return summarize(run_study(study));
}

TEST(ChainStudy, CylindersInPicturesBecomeTheMap) {
  World world = read_world(config("worlds/room.yaml"));
  world.drive.loops = 1;
  world.pictures.rate = 2.0;
  DetectorOptions detector;
  detector.palette = config("palette.yaml");
  const RoomSummary summary = chain(world, detector, {});
  EXPECT_EQ(summary.exact_count_share, 1.0);
  EXPECT_EQ(summary.wrong_labels.worst, 0.0);
  EXPECT_LE(summary.landmark_rmse_aligned.worst, 0.02);
}

TEST(ChainStudy, NaturalFeaturesCarryARobotThatFlies) {
  World world = read_world(config("worlds/room_textured.yaml"));
  world.drive.waypoints_in_world.resize(2);
  DetectorOptions detector;
  detector.type = DetectorType::kFeatures;
  const RoomSummary summary = chain(world, detector, {config("features.yaml")});
  EXPECT_EQ(summary.pose_dof, 6);
  EXPECT_LE(summary.path_rmse.worst, 0.05);
  EXPECT_LE(summary.nees.worst, 9.0);
}

}  // namespace
}  // namespace kinect_ekf_slam
