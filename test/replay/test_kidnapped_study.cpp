#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "kinect_ekf_slam/ros/configuration.h"
#include "kinect_ekf_slam/study/kidnapped_study.h"

namespace kinect_ekf_slam {
namespace {

/// As slam_study kidnapped has it; the README's hundred robots are that command's.
TEST(KidnappedStudy, RobotsAreFoundAndNoneIsSureOfAWrongPlace) {
  KidnappedStudy study;
  study.world =
      read_world((std::filesystem::path(__FILE__).parent_path() / "../../config/worlds/room.yaml").string());
  study.pipeline = read_run_options({}, {}, [](const std::string& line) { FAIL() << line; }).pipeline;
  study.robots = 30;
  for (const bool looks : {true, false}) {
    study.looks = looks;
    const auto runs = run_study(study);
    const auto right =
        std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.is_right(); });
    EXPECT_GE(right, 29);
    for (const KidnappedRun& run : runs) {
      EXPECT_FALSE(run.found && run.position_error > 0.2) << "seed " << run.seed;
    }
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
