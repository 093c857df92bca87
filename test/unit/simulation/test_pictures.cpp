#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/rgbd_camera.h"
#include "test/support/matchers.h"
#include "test/unit/simulation/small_world.h"

namespace kinect_ekf_slam::testing {
namespace {

int count_pictures(double rate) {
  World world = exact_world();
  world.pictures.rate = rate;
  int count = 0;
  for (const Sample& sample : run(world, 1, 4.0)) count += sample.takes_picture ? 1 : 0;
  return count;
}

TEST(Pictures, AreTakenAtTheirRateFromTheStartOn) {
  EXPECT_EQ(count_pictures(0.0), 0);
  EXPECT_EQ(count_pictures(5.0), 21);
  EXPECT_EQ(count_pictures(7.0), 29);
}

TEST(Pictures, LeaveTheOtherSensorsAsTheyWere) {
  World world = exact_world();
  world.wheels = WheelOptions();
  world.sensor.noise_scale = 1.0;
  world.drive.waypoints_in_world = {{12.0, 10.0, 0.0}};
  world.landmarks = {cylinder(1, 1.5, 0.1)};
  const auto sightings = [&](double rate) {
    world.pictures.rate = rate;
    std::vector<Eigen::Vector3d> positions;
    for (const Sample& sample : run(world, 3, 5.0)) {
      if (!sample.sightings) continue;
      for (const Sighting& sighting : *sample.sightings) positions.push_back(sighting.position_in_optical);
    }
    return positions;
  };
  const auto without = sightings(0.0);
  const auto with = sightings(7.0);
  ASSERT_EQ(without.size(), with.size());
  ASSERT_FALSE(with.empty());
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_TRUE(MatrixNear(with[i], without[i], 1e-9));
}

TEST(Scene, ABallLooksRoundFromAllSides) {
  Scene scene;
  scene.add_ball({2.0, 0.0, 0.5}, 0.3, paint("red"));
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
  world_from_optical.translation().z() = 0.5;
  world_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const RgbdImage image = render(scene, world_from_optical, {});
  const double radius = 525.0 * 0.3 / std::sqrt(2.0 * 2.0 - 0.3 * 0.3);  // pixels, of the sphere's outline
  int covered = 0;
  for (const float depth : image.depth) covered += depth > 0.0F ? 1 : 0;
  EXPECT_NEAR(covered, kPi * radius * radius, 0.05 * kPi * radius * radius);
  EXPECT_NEAR(image.depth[240 * 640 + 320], 1.7F, 0.01F);
}

TEST(Scene, AnUnknownLabelIsGrey) {
  const Rgb colour = paint("quantum");
  EXPECT_EQ(colour.red, colour.green);
  EXPECT_EQ(colour.red, colour.blue);
}

}  // namespace
}  // namespace kinect_ekf_slam::testing
