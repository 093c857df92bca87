#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "kinect_ekf_slam/perception/kinect_cylinder.h"
#include "kinect_ekf_slam/simulation/rgbd_camera.h"
#include "kinect_ekf_slam/simulation/scene.h"

namespace kinect_ekf_slam {

/// A corner of a random room: cylinders that are landmarks, and boxes, legs, bowls and a wall that are none.
struct CylinderView {
  Scene scene;
  std::vector<RoundBody> cylinders;  ///< of the scene's bodies, those that are landmarks
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
};

CylinderView random_cylinder_view(std::uint64_t seed);

/// Random views through the cylinder detector.
struct CylinderStudy {
  KinectCylinderOptions detector;
  Palette palette;
  RgbdCameraOptions camera;
  std::uint64_t first_seed = 1;
  int views = 200;
  double nearest = 0.6;  ///< m of depth, between which cylinders must be found and findings be cylinders
  double farthest = 2.6;
  std::function<void(double)> on_progress;  ///< share done, 0 to 1; may be empty
};

struct CylinderStudyResult {
  int expected = 0;   ///< free and whole in the picture, between the two depths
  int found = 0;      ///< of those
  int true_ones = 0;  ///< findings that are a cylinder, expected or not
  int false_ones = 0;
  int wrong_labels = 0;
  double center_rmse = 0.0;  ///< m
  double radius_rmse = 0.0;  ///< m
  double nees_mean = 0.0;    ///< of the axis point; 3 when consistent
  double nees_low = 0.0;     ///< where the mean lies with 95 % probability if it is
  double nees_high = 0.0;
  double milliseconds = 0.0;  ///< of the detector, mean

  double recall() const { return expected > 0 ? static_cast<double>(found) / expected : 1.0; }
  double precision() const {
    return true_ones + false_ones > 0 ? static_cast<double>(true_ones) / (true_ones + false_ones) : 1.0;
  }
};

/// The picture of the study's first view.
RgbdPicture first_picture(const CylinderStudy& study);

CylinderStudyResult run_study(const CylinderStudy& study);

std::string to_table(const CylinderStudyResult& result);

}  // namespace kinect_ekf_slam
