#pragma once

#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/simulation/rgbd_camera.h"

namespace kinect_ekf_slam {

/// The simulated camera's picture as the detectors take it.
RgbdPicture to_picture(const RgbdImage& image, const RgbdCameraOptions& options);

}  // namespace kinect_ekf_slam
