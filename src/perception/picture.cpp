#include "kinect_ekf_slam/perception/picture.h"

#include <cmath>
#include <limits>
#include <string>

namespace kinect_ekf_slam {
namespace {

std::string size_text(const cv::Mat& image) {
  return std::to_string(image.cols) + " x " + std::to_string(image.rows);
}

}  // namespace

void check(const RgbdPicture& picture) {
  const auto& [colour, depth, camera] = picture;
  if (colour.empty() && depth.empty()) throw PictureError("neither colour nor depth in the picture");
  if (!colour.empty() && colour.type() != CV_8UC3) {
    throw PictureError("colour is of type " + cv::typeToString(colour.type()) + ", allowed: CV_8UC3");
  }
  if (!depth.empty() && depth.type() != CV_16UC1 && depth.type() != CV_32FC1) {
    throw PictureError("depth is of type " + cv::typeToString(depth.type()) +
                       ", allowed: CV_16UC1 (mm), CV_32FC1 (m)");
  }
  if (!colour.empty() && !depth.empty() && colour.size() != depth.size()) {
    throw PictureError("colour is " + size_text(colour) + " and depth " + size_text(depth) +
                       " pixels: registered depth is needed");
  }
  constexpr double kFarthest = 1e6;  // pixels; beyond them squares of what is seen overflow
  for (const double focal_length : {camera.fx, camera.fy}) {
    if (focal_length >= 1.0 && focal_length <= kFarthest) continue;
    throw PictureError("the camera has no focal length, of 1 to 1e6 pixels: is it calibrated?");
  }
  for (const double centre : {camera.cx, camera.cy}) {
    if (std::abs(centre) <= kFarthest) continue;
    throw PictureError("the camera's centre is more than 1e6 pixels off: is it calibrated?");
  }
}

cv::Mat depth_in_metres(const cv::Mat& depth) {
  constexpr double kMillimetre = 1e-3;  // m
  cv::Mat metres;
  depth.convertTo(metres, CV_32FC1, depth.type() == CV_16UC1 ? kMillimetre : 1.0);
  for (int v = 0; v < metres.rows; ++v) {
    float* row = metres.ptr<float>(v);
    for (int u = 0; u < metres.cols; ++u) {
      if (!(row[u] > 0.0F) || std::isinf(row[u])) row[u] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return metres;
}

}  // namespace kinect_ekf_slam
