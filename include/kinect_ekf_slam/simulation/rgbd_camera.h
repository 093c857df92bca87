#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "kinect_ekf_slam/simulation/random_stream.h"
#include "kinect_ekf_slam/simulation/scene.h"

namespace kinect_ekf_slam {

/// What a depth camera at a place in the world shows. Rows follow each other from the upper left corner.
struct RgbdImage {
  int width = 0;
  int height = 0;
  std::vector<Rgb> colour;
  std::vector<float> depth;      ///< m, 0: nothing there, or no reading
  std::vector<float> incidence;  ///< cosine of the angle between ray and surface
};

/// A Kinect: an ideal pinhole, and the errors of its depth.
struct RgbdCameraOptions {
  int width = 640;
  int height = 480;
  double focal_length = 525.0;  ///< pixels; the optical centre is the middle of the picture
  /// Rays for each side of a pixel: the colours of an edge mix. Odd, so that one of them is in the middle.
  int samples = 1;

  double min_depth = 0.5;        ///< m; nearer there is no reading
  double max_depth = 5.0;        ///< m
  double depth_scale = 1.0;      ///< reading over true depth
  double step_per_m = 2.85e-3;   ///< 1/m: the step of depth Z is this times Z^2
  double sigma_per_m = 1.43e-3;  ///< 1/m: of one reading, like the step
  double shadow_baseline =
      0.075;                     ///< m, from the projector to the camera; what lies between them has no depth
  int half_window = 4;           ///< pixels: it compares windows of nine by nine
  double grazing_cosine = 0.12;  ///< incidence below which the light does not come back
  double missing_rate = 0.003;   ///< share of readings that fail for no reason
  double colour_sigma = 3.0;     ///< of each channel, of 255
};

/// The picture without errors. `world_from_optical` has optical axes: X right, Y down, Z forward.
RgbdImage render(const Scene& scene, const Eigen::Isometry3d& world_from_optical,
                 const RgbdCameraOptions& options);

/// Adds the errors of a Kinect: windows that smooth and let edges grow, shadow, noise, steps, missing
/// readings, noise of the colours. (Khoshelham and Oude Elberink, Sensors 12(2), 2012.)
void add_kinect_errors(const RgbdCameraOptions& options, RandomStream* random, RgbdImage* image);

}  // namespace kinect_ekf_slam
