#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Header.h>
#include <stereo_msgs/DisparityImage.h>

#include "kinect_ekf_slam/perception/picture.h"

namespace kinect_ekf_slam {

/// Messages as a picture, whose pixels may be the messages' own: it lives no longer than they do. All throw
/// PictureError, or what cv_bridge and image_geometry throw, with one line that says why.
RgbdPicture to_picture(const sensor_msgs::ImageConstPtr& colour, const sensor_msgs::CameraInfo& info);
/// Depth in mm or m, registered to the colour.
RgbdPicture to_picture(const sensor_msgs::ImageConstPtr& colour, const sensor_msgs::ImageConstPtr& depth,
                       const sensor_msgs::CameraInfo& info);
/// Disparity of a stereo camera whose left picture `colour` is. Depth is focal length times baseline over
/// disparity.
RgbdPicture to_picture(const sensor_msgs::ImageConstPtr& colour, const stereo_msgs::DisparityImage& disparity,
                       const sensor_msgs::CameraInfo& info);

/// A picture as the driver of a Kinect publishes it.
struct PictureMessages {
  sensor_msgs::ImagePtr colour;  ///< bgr8
  sensor_msgs::ImagePtr depth;   ///< 16UC1 mm, registered
  sensor_msgs::CameraInfoPtr info;
};
/// The picture must have colour and depth in mm.
PictureMessages to_messages(const RgbdPicture& picture, const std_msgs::Header& header);

}  // namespace kinect_ekf_slam
