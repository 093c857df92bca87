#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/simulation/rgbd_camera.h"
#include "kinect_ekf_slam/simulation/scene.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace kinect_ekf_slam {

/// The simulated camera's picture as the detectors take it.
RgbdPicture to_picture(const RgbdImage& image, const RgbdCameraOptions& options);

/// What the world looks like: floor, walls, panels, and its landmarks in the colours of their labels. A
/// cylinder is twice as high as its detected centre.
Scene make_scene(const World& world);

/// The Kinect of a simulated robot. The same world, seed and way give the same pictures.
class SimulatedCamera {
 public:
  SimulatedCamera(const World& world, std::uint64_t seed);

  RgbdPicture take(const Eigen::Isometry3d& world_from_base);

 private:
  PictureOptions options_;
  Eigen::Isometry3d base_from_optical_;
  Scene scene_;
  RandomStream random_;
};

}  // namespace kinect_ekf_slam
