#include "kinect_ekf_slam/study/robustness_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace kinect_ekf_slam {
namespace {

/// The report's room with a detector that makes no mistakes, but for its noise.
RoomStudy clean_room(int seeds) {
  RoomStudy study;
  study.world = read_world(
      (std::filesystem::path(__FILE__).parent_path() / "../../../config/worlds/room.yaml").string());
  study.seeds = seeds;
  return study;
}

Fault fault_named(const std::string& name) {
  for (const Fault& fault : common_faults()) {
    if (fault.name == name) return fault;
  }
  throw std::invalid_argument(name);
}

TEST(RobustnessStudy, EveryFaultHasAPlaceOfItsOwnAndStrengthsInOrder) {
  RoomStudy study = clean_room(1);
  std::set<const double*> places;
  for (const Fault& fault : common_faults()) {
    EXPECT_TRUE(places.insert(&fault.strength_in(study)).second) << fault.name;
    EXPECT_TRUE(std::is_sorted(fault.strengths.begin(), fault.strengths.end())) << fault.name;
    EXPECT_GE(fault.strengths.size(), 5U) << fault.name;
  }
}

TEST(RobustnessStudy, TheBasePointIsOneOfThePoints) {
  RoomStudy study = clean_room(2);
  Fault fault = fault_named("missed detections");
  fault.strengths = {0.0, 0.4};
  fault.strength_in(study) = 0.123;
  const std::vector<FaultSweep> sweeps = run_robustness(study, {fault});
  ASSERT_EQ(sweeps.size(), 1U);
  ASSERT_EQ(sweeps[0].points.size(), 3U);
  EXPECT_EQ(sweeps[0].base_strength, 0.123);
  EXPECT_EQ(sweeps[0].points[1].strength, 0.123);
  study.pipeline = textbook(study.pipeline);
  EXPECT_EQ(sweeps[0].points[1].textbook.path_rmse.mean, summarize(run_study(study)).path_rmse.mean)
      << "the study with nothing changed";
}

TEST(RobustnessStudy, FalseDetectionsSpoilTheTextbooksMap) {
  Fault fault = fault_named("false detections");
  fault.strengths = {0.0, 20.0};
  const std::vector<FaultSweep> sweeps = run_robustness(clean_room(8), {fault});
  const std::vector<RobustnessPoint>& points = sweeps[0].points;
  EXPECT_EQ(points[0].textbook.success_share, 1.0);
  EXPECT_EQ(points[0].textbook.runs, 8U);
  EXPECT_LE(points[1].textbook.success_share, 0.2);
  EXPECT_GT(points[1].textbook.spurious.mean, 5.0);
}

TEST(RobustnessStudy, LateOdometryMovesThePath) {
  RoomStudy study = clean_room(4);
  const double in_time = summarize(run_study(study)).path_rmse.mean;
  study.odometry_delay = 0.4;
  EXPECT_GT(summarize(run_study(study)).path_rmse.mean, in_time + 0.02);
}

TEST(RobustnessStudy, TheSameSeedsGiveTheSameFigures) {
  Fault fault = fault_named("gross errors");
  fault.strengths = {0.1};
  const auto figures = [&] { return to_json(run_robustness(clean_room(3), {fault})); };
  EXPECT_EQ(figures(), figures());
}

}  // namespace
}  // namespace kinect_ekf_slam
