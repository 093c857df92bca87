#include "kinect_ekf_slam/ros/picture_messages.h"

#include <cv_bridge/cv_bridge.h>
#include <image_geometry/pinhole_camera_model.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <string>

namespace kinect_ekf_slam {
namespace {

namespace encodings = sensor_msgs::image_encodings;

PinholeCamera camera_of(const sensor_msgs::CameraInfo& info, const cv::Mat& image) {
  if (static_cast<int>(info.width) != image.cols || static_cast<int>(info.height) != image.rows) {
    throw PictureError("camera_info is for " + std::to_string(info.width) + " x " +
                       std::to_string(info.height) + " pixels, the picture has " +
                       std::to_string(image.cols) + " x " + std::to_string(image.rows));
  }
  image_geometry::PinholeCameraModel model;
  model.fromCameraInfo(info);
  return {model.fx(), model.fy(), model.cx(), model.cy()};
}

void require_frame(const std_msgs::Header& depth, const std_msgs::Header& colour) {
  if (depth.frame_id == colour.frame_id) return;
  throw PictureError("depth is in frame '" + depth.frame_id + "', colour in '" + colour.frame_id +
                     "': registered depth is needed");
}

void require_encoding(bool is_allowed, const std::string& what, const std::string& encoding,
                      const std::string& allowed) {
  if (!is_allowed) throw PictureError(what + " has the encoding '" + encoding + "', allowed: " + allowed);
}

}  // namespace

RgbdPicture to_picture(const sensor_msgs::ImageConstPtr& colour, const sensor_msgs::CameraInfo& info) {
  RgbdPicture picture;
  picture.colour = cv_bridge::toCvShare(colour, encodings::BGR8)->image;  // checks step and size of the data
  picture.camera = camera_of(info, picture.colour);
  return picture;
}

RgbdPicture to_picture(const sensor_msgs::ImageConstPtr& colour, const sensor_msgs::ImageConstPtr& depth,
                       const sensor_msgs::CameraInfo& info) {
  require_frame(depth->header, colour->header);
  require_encoding(depth->encoding == encodings::TYPE_16UC1 || depth->encoding == encodings::MONO16 ||
                       depth->encoding == encodings::TYPE_32FC1,
                   "depth", depth->encoding, "16UC1 (mm), 32FC1 (m)");
  RgbdPicture picture = to_picture(colour, info);
  picture.depth = cv_bridge::toCvShare(depth)->image;
  return picture;
}

RgbdPicture to_picture(const sensor_msgs::ImageConstPtr& colour, const stereo_msgs::DisparityImage& disparity,
                       const sensor_msgs::CameraInfo& info) {
  require_frame(disparity.header, colour->header);
  require_encoding(disparity.image.encoding == encodings::TYPE_32FC1, "disparity", disparity.image.encoding,
                   "32FC1 (pixels)");
  const double reach = static_cast<double>(disparity.f) * disparity.T;  // m, times pixels
  if (!std::isfinite(reach) || reach <= 0.0) {
    throw PictureError("disparity has no focal length or no baseline");
  }
  RgbdPicture picture = to_picture(colour, info);
  const cv::Mat pixels = cv_bridge::toCvCopy(disparity.image)->image;
  picture.depth.create(pixels.size(), CV_32FC1);
  for (int row = 0; row < pixels.rows; ++row) {
    for (int column = 0; column < pixels.cols; ++column) {
      const float value = pixels.at<float>(row, column);
      const bool is_reading = value > 0.0F && value >= disparity.min_disparity;
      picture.depth.at<float>(row, column) = is_reading ? static_cast<float>(reach / value) : 0.0F;
    }
  }
  return picture;
}

PictureMessages to_messages(const RgbdPicture& picture, const std_msgs::Header& header) {
  PictureMessages messages;
  messages.colour = cv_bridge::CvImage(header, encodings::BGR8, picture.colour).toImageMsg();
  messages.depth = cv_bridge::CvImage(header, encodings::TYPE_16UC1, picture.depth).toImageMsg();
  messages.info = boost::make_shared<sensor_msgs::CameraInfo>();
  sensor_msgs::CameraInfo& info = *messages.info;
  info.header = header;
  info.width = static_cast<std::uint32_t>(picture.colour.cols);
  info.height = static_cast<std::uint32_t>(picture.colour.rows);
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0.0);
  const PinholeCamera& camera = picture.camera;
  info.K = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  return messages;
}

}  // namespace kinect_ekf_slam
