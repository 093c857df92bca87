#include "kinect_ekf_slam/simulation/rgbd_camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinect_ekf_slam {
namespace {

/// Looks along the world's X from a height of 0.5 m.
Eigen::Isometry3d level_camera() {
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
  world_from_optical.translation().z() = 0.5;
  world_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return world_from_optical;
}

Scene wall_at(double distance) {
  Scene scene;
  scene.panels.push_back(
      {{distance, 5.0, 5.0}, {0.0, -10.0, 0.0}, {0.0, 0.0, -10.0}, Texture(Rgb{200, 100, 50})});
  return scene;
}

float depth_at(const RgbdImage& image, int column, int row) {
  return image.depth[row * image.width + column];
}

TEST(RgbdCamera, SeesTheDepthOfAWallEverywhereAlike) {
  const RgbdImage image = render(wall_at(2.0), level_camera(), {});
  for (const int column : {0, 320, 639}) EXPECT_NEAR(depth_at(image, column, 240), 2.0F, 1e-5F);
}

TEST(RgbdCamera, TheNearestSurfaceIsSeen) {
  Scene scene = wall_at(3.0);
  scene.bodies.push_back({{1.5, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.1, 0.1, {10, 200, 10}});
  const RgbdImage image = render(scene, level_camera(), {});
  EXPECT_NEAR(depth_at(image, 320, 240), 1.4F, 1e-3F);
  EXPECT_NEAR(depth_at(image, 100, 240), 3.0F, 1e-5F);
  EXPECT_GT(image.colour[240 * 640 + 320].green, 5 * image.colour[240 * 640 + 320].red);
}

TEST(RgbdCamera, AConeTapersAndHasALid) {
  Scene scene;
  scene.bodies.push_back({{1.0, 0.0, 0.0}, {0.0, 0.0, 0.8}, 0.1, 0.2, {10, 200, 10}});
  const RgbdImage image = render(scene, level_camera(), {});
  const double foot_edge = depth_at(image, 320, 240 + 150);  // nearer to the top the wall comes nearer
  EXPECT_LT(depth_at(image, 320, 240 - 100), foot_edge);
  Eigen::Isometry3d above = level_camera();
  above.translation().z() = 1.2;
  EXPECT_GT(depth_at(render(scene, above, {}), 320, 480 - 20), 0.0F);
}

TEST(RgbdCamera, PatternsAreSeenUpright) {
  Scene scene;
  const Texture pattern(2, 2, {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}});
  scene.panels.push_back({{2.0, 0.5, 1.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, -1.0}, pattern});
  const RgbdImage image = render(scene, level_camera(), {});
  const auto pixel = [&](int column, int row) { return image.colour[row * image.width + column]; };
  EXPECT_GT(pixel(260, 180).red, pixel(260, 180).green);
  EXPECT_GT(pixel(380, 180).green, pixel(380, 180).red);
  EXPECT_GT(pixel(260, 300).blue, pixel(260, 300).red);
}

TEST(KinectErrors, DepthComesInStepsAndIsRightInTheMean) {
  RgbdImage image = render(wall_at(2.0), level_camera(), {});
  RandomStream random(3, 0);
  const RgbdCameraOptions options;
  add_kinect_errors(options, &random, &image);
  double sum = 0.0;
  double squared = 0.0;
  int count = 0;
  int missing = 0;
  for (const float reading : image.depth) {
    if (reading == 0.0F) {
      ++missing;
      continue;
    }
    const double steps = 1.0 / (options.step_per_m * reading);
    EXPECT_NEAR(steps, std::round(steps), 1e-3);
    sum += reading - 2.0;
    squared += (reading - 2.0) * (reading - 2.0);
    ++count;
  }
  EXPECT_NEAR(sum / count, 0.0, 1e-3);
  const double expected = std::hypot(options.sigma_per_m, options.step_per_m / std::sqrt(12.0)) * 4.0;
  EXPECT_NEAR(std::sqrt(squared / count), expected, 0.1 * expected);
  EXPECT_NEAR(static_cast<double>(missing) / image.depth.size(), options.missing_rate, 0.001);
}

TEST(KinectErrors, AnObjectGrowsAndThrowsAShadowToTheLeft) {
  RgbdCameraOptions options;
  options.missing_rate = 0.0;
  Scene scene = wall_at(3.0);
  scene.add_box({1.05, 0.0}, 0.0, {0.1, 0.2, 1.0}, {50, 50, 50});
  RgbdImage image = render(scene, level_camera(), options);
  const int left = 320 - 52;
  const int right = 320 + 52;
  ASSERT_NEAR(depth_at(image, right + 3, 240), 3.0F, 1e-5F);
  RandomStream random(3, 0);
  add_kinect_errors(options, &random, &image);
  EXPECT_NEAR(depth_at(image, right + 3, 240), 1.0F, 0.02F);
  EXPECT_NEAR(depth_at(image, right + 8, 240), 3.0F, 0.1F);
  EXPECT_EQ(depth_at(image, left - 10, 240), 0.0F);
  EXPECT_NEAR(depth_at(image, left - 40, 240), 3.0F, 0.1F);
}

}  // namespace
}  // namespace kinect_ekf_slam
