#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <stdexcept>

namespace kinect_ekf_slam {

/// An ideal pinhole, without distortion. Pixels (u right, v down) count from the centre of the first one.
struct PinholeCamera {
  double fx = 525.0;  ///< pixels
  double fy = 525.0;
  double cx = 319.5;
  double cy = 239.5;

  /// The point at depth 1 m on the ray through a pixel, in the optical frame.
  Eigen::Vector3d ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }
  /// Where a point of the optical frame with positive depth is seen.
  Eigen::Vector2d project(const Eigen::Vector3d& point_in_optical) const {
    return {fx * point_in_optical.x() / point_in_optical.z() + cx,
            fy * point_in_optical.y() / point_in_optical.z() + cy};
  }
};

/// Colour and the depth that belongs to each of its pixels, as a Kinect's driver registers them.
struct RgbdPicture {
  cv::Mat colour;  ///< 8UC3, blue green red; empty: there is none
  cv::Mat depth;   ///< 16UC1 millimetres or 32FC1 metres, 0 or NaN: no reading; empty: there is none
  PinholeCamera camera;
};

/// A picture that no detector can use. One line says why.
class PictureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws PictureError for a type other than those named above, pictures of different sizes, no picture at
/// all, and a camera that is none (not finite, focal lengths not positive).
void check(const RgbdPicture& picture);

/// Depth as 32FC1 in m, NaN where there is no reading.
cv::Mat depth_in_metres(const cv::Mat& depth);

}  // namespace kinect_ekf_slam
