#include "kinect_ekf_slam/study/simulated_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "kinect_ekf_slam/perception/fiducial.h"
#include "kinect_ekf_slam/perception/kinect_cylinder.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

World room() {
  const auto path = std::filesystem::path(__FILE__).parent_path() / "../../../config/worlds/room.yaml";
  return read_world(path.string());
}

Palette palette() {
  const auto path = std::filesystem::path(__FILE__).parent_path() / "../../../config/palette.yaml";
  return read_palette(path.string());
}

TEST(SimulatedCamera, ShowsTheWorldsCylindersToTheirDetector) {
  const World world = room();
  const Eigen::Isometry3d world_from_base = world.drive.world_from_start.to_3d();
  const Eigen::Isometry3d world_from_optical = world_from_base * world.sensor.base_from_optical;
  SimulatedCamera camera(world, 1);
  const Eigen::Vector3d up = world.sensor.base_from_optical.linear().row(2);
  const Findings findings = KinectCylinderDetector({}, palette()).detect(camera.take(world_from_base), up);
  EXPECT_GE(findings.found.size(), 2U);
  for (const Finding& finding : findings.found) {
    const Eigen::Vector3d place = world_from_optical * finding.position;
    const auto truth = std::find_if(
        world.landmarks.begin(), world.landmarks.end(),
        [&](const auto& landmark) { return (landmark.position_in_world - place).norm() < 0.05; });
    ASSERT_NE(truth, world.landmarks.end()) << place.transpose();
    EXPECT_EQ(finding.signature.label, truth->label);
    EXPECT_NEAR(finding.signature.radius, truth->radius, 0.01);
  }
}

TEST(SimulatedCamera, ShowsFiducialsWhereTheyAre) {
  World world = room();
  WorldPanel panel;
  panel.center_in_world = Eigen::Vector3d(2.8, 1.55, 0.3);
  panel.facing_deg = 185.0;
  panel.size = 0.15;
  panel.print = WorldPanel::Print::kFiducial;
  panel.id = 23;
  world.panels = {panel};
  const Eigen::Isometry3d world_from_base = world.drive.world_from_start.to_3d();
  const Findings findings = FiducialDetector({}).detect(SimulatedCamera(world, 1).take(world_from_base));
  ASSERT_EQ(findings.found.size(), 1U);
  EXPECT_EQ(findings.found[0].signature.source_id, 23);
  const Eigen::Vector3d place = world_from_base * world.sensor.base_from_optical * findings.found[0].position;
  EXPECT_TRUE(testing::MatrixNear(place, panel.center_in_world, 0.03));
}

TEST(SimulatedCamera, TheSameSeedGivesTheSamePictures) {
  const World world = room();
  const Eigen::Isometry3d world_from_base = world.drive.world_from_start.to_3d();
  const auto differs = [&](std::uint64_t seed, std::uint64_t other) {
    const RgbdPicture one = SimulatedCamera(world, seed).take(world_from_base);
    const RgbdPicture two = SimulatedCamera(world, other).take(world_from_base);
    return cv::norm(one.colour, two.colour, cv::NORM_INF) + cv::norm(one.depth, two.depth, cv::NORM_INF) >
           0.0;
  };
  EXPECT_FALSE(differs(1, 1));
  EXPECT_TRUE(differs(1, 2));
}

TEST(SimulatedCamera, BlotchesCoverAllSurfaces) {
  World world = room();
  world.pictures.has_errors = false;
  const Eigen::Isometry3d world_from_base = world.drive.world_from_start.to_3d();
  const auto spread = [&] {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(SimulatedCamera(world, 1).take(world_from_base).colour.rowRange(400, 480), mean,
                   deviation);
    return deviation[0];
  };
  EXPECT_LT(spread(), 5.0);
  world.has_blotches = true;
  EXPECT_GT(spread(), 30.0);
}

}  // namespace
}  // namespace kinect_ekf_slam
