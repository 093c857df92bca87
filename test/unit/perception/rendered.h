#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/simulation/rgbd_camera.h"

namespace kinect_ekf_slam::testing {

/// A camera over the origin that looks along X, tilted downwards by `tilt` (rad).
inline Eigen::Isometry3d camera_at(double height, double tilt) {
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
  world_from_optical.translation().z() = height;
  Eigen::Matrix3d world_from_level;
  world_from_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  world_from_optical.linear() =
      world_from_level * Eigen::AngleAxisd(-tilt, Eigen::Vector3d::UnitX()).matrix();
  return world_from_optical;
}

inline Scene floor_and_wall() {
  Scene scene;
  scene.panels.push_back(
      {{-5.0, -5.0, 0.0}, {10.0, 0.0, 0.0}, {0.0, 10.0, 0.0}, Texture(Rgb{120, 120, 120})});
  scene.panels.push_back({{4.0, -5.0, 3.0}, {0.0, 10.0, 0.0}, {0.0, 0.0, -3.0}, Texture(Rgb{180, 180, 180})});
  return scene;
}

inline RoundBody standing(double x, double y, double radius, double height, Rgb colour = {190, 35, 30}) {
  return {{x, y, 0.0}, {0.0, 0.0, height}, radius, radius, colour};
}

inline RgbdPicture photograph(const Scene& scene, const Eigen::Isometry3d& world_from_optical,
                              std::uint64_t seed = 1, bool with_errors = true,
                              const RgbdCameraOptions& options = {}) {
  RandomStream random(seed, 0);
  RgbdImage image = render(scene, world_from_optical, options);
  if (with_errors) add_kinect_errors(options, &random, &image);
  RgbdPicture picture;
  picture.colour.create(image.height, image.width, CV_8UC3);
  picture.depth = cv::Mat(image.height, image.width, CV_32FC1, image.depth.data()).clone();
  for (std::size_t i = 0; i < image.colour.size(); ++i) {
    const Rgb& pixel = image.colour[i];
    picture.colour.at<cv::Vec3b>(static_cast<int>(i) / image.width, static_cast<int>(i) % image.width) = {
        pixel.blue, pixel.green, pixel.red};
  }
  return picture;
}

}  // namespace kinect_ekf_slam::testing
