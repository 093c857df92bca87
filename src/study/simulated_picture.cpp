#include "kinect_ekf_slam/study/simulated_picture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/perception/fiducial.h"

namespace kinect_ekf_slam {
namespace {

constexpr std::uint32_t kCameraStream = 3;  // the simulator has those before it

/// A plain colour, or blotches of a few centimetres.
Texture surface(const Rgb& colour, const Eigen::Vector2d& size, bool has_blotches, std::uint64_t seed) {
  constexpr double kResolution = 0.01;  // m
  if (!has_blotches) return Texture(colour);
  const Eigen::Vector2i pixels = (size / kResolution).cast<int>().cwiseMax(1);
  return blotches(pixels.x(), pixels.y(), seed);
}

void add_room(const World& world, Scene* scene) {
  const Eigen::Vector3d x = world.room_size.x() * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = world.room_size.y() * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d up = world.wall_height * Eigen::Vector3d::UnitZ();
  std::uint64_t seed = 0;
  const auto add = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& along,
                       const Eigen::Vector3d& down, const Rgb& colour) {
    const Eigen::Vector2d size(along.norm(), down.norm());
    scene->panels.push_back({corner, along, down, surface(colour, size, world.has_blotches, ++seed)});
  };
  constexpr Rgb kFloor{120, 120, 120};
  constexpr Rgb kWall{185, 185, 180};
  add(y, x, -y, kFloor);
  add(y + up, x, -up, kWall);
  add(x + y + up, -y, -up, kWall);
  add(x + up, -x, -up, kWall);
  add(up, y, -up, kWall);
  if (world.is_spatial()) add(up, x, y, kWall);
}

Panel make_panel(const WorldPanel& panel) {
  const double facing = radians(panel.facing_deg);
  if (panel.print == WorldPanel::Print::kBlotches) {
    const Eigen::Vector2d size(panel.size, panel.size);
    constexpr std::uint64_t kFirstPattern = 100;  // those before it are on the walls
    return upright_panel(panel.center_in_world, facing, panel.size,
                         surface({}, size, true, kFirstPattern + static_cast<std::uint64_t>(panel.id)));
  }
  const std::vector<std::string> pattern = fiducial_pattern(FiducialOptions().dictionary, panel.id);
  const auto modules = static_cast<double>(pattern.size());
  return upright_panel(panel.center_in_world, facing, panel.size * (modules + 2.0) / modules,
                       printed(pattern));
}

}  // namespace

RgbdPicture to_picture(const RgbdImage& image, const RgbdCameraOptions& options) {
  constexpr double kMillimetre = 1e-3;  // m
  RgbdPicture picture;
  picture.camera = {options.focal_length, options.focal_length, 0.5 * (image.width - 1),
                    0.5 * (image.height - 1)};
  picture.colour.create(image.height, image.width, CV_8UC3);
  picture.depth.create(image.height, image.width, CV_16UC1);
  std::size_t index = 0;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column, ++index) {
      const Rgb& pixel = image.colour[index];
      picture.colour.at<cv::Vec3b>(row, column) = {pixel.blue, pixel.green, pixel.red};
      picture.depth.at<std::uint16_t>(row, column) =
          static_cast<std::uint16_t>(std::lround(image.depth[index] / kMillimetre));
    }
  }
  return picture;
}

Scene make_scene(const World& world) {
  Scene scene;
  add_room(world, &scene);
  for (const WorldPanel& panel : world.panels) scene.panels.push_back(make_panel(panel));
  for (const WorldLandmark& landmark : world.landmarks) {
    const Eigen::Vector3d& center = landmark.position_in_world;
    if (world.is_spatial()) {
      scene.add_ball(center, landmark.radius, paint(landmark.label));
    } else {
      scene.bodies.push_back({{center.x(), center.y(), 0.0},
                              {0.0, 0.0, 2.0 * std::max(center.z(), landmark.radius)},
                              landmark.radius,
                              landmark.radius,
                              paint(landmark.label)});
    }
  }
  return scene;
}

SimulatedCamera::SimulatedCamera(const World& world, std::uint64_t seed)
    : options_(world.pictures),
      base_from_optical_(world.sensor.base_from_optical),
      scene_(make_scene(world)),
      random_(seed, kCameraStream) {}

RgbdPicture SimulatedCamera::take(const Eigen::Isometry3d& world_from_base) {
  RgbdImage image = render(scene_, world_from_base * base_from_optical_, options_.camera);
  if (options_.has_errors) add_kinect_errors(options_.camera, &random_, &image);
  return to_picture(image, options_.camera);
}

}  // namespace kinect_ekf_slam
