#include "kinect_ekf_slam/ros/simulated_picture.h"

#include <cmath>

namespace kinect_ekf_slam {

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

}  // namespace kinect_ekf_slam
