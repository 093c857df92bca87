#include "kinect_ekf_slam/ros/picture_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace kinect_ekf_slam {
namespace {

RgbdPicture small_picture() {
  RgbdPicture picture;
  picture.colour = cv::Mat(4, 6, CV_8UC3, cv::Scalar(10, 20, 30));
  picture.depth = cv::Mat(4, 6, CV_16UC1, cv::Scalar(1500));
  picture.camera = {500.0, 510.0, 2.5, 1.5};
  return picture;
}

std_msgs::Header header() {
  std_msgs::Header header;
  header.frame_id = "camera_optical_frame";
  return header;
}

stereo_msgs::DisparityImage disparity_of(float pixels) {
  stereo_msgs::DisparityImage disparity;
  disparity.header = header();
  disparity.f = 500.0F;
  disparity.T = 0.1F;
  disparity.image.width = 6;
  disparity.image.height = 4;
  disparity.image.encoding = "32FC1";
  disparity.image.step = 6 * sizeof(float);
  disparity.image.data.resize(4 * disparity.image.step);
  for (std::size_t i = 0; i < 24; ++i) reinterpret_cast<float*>(disparity.image.data.data())[i] = pixels;
  return disparity;
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& reason) {
    return reason.what();
  }
  return "no refusal";
}

TEST(PictureMessages, GoThereAndBack) {
  const RgbdPicture sent = small_picture();
  const PictureMessages messages = to_messages(sent, header());
  const RgbdPicture received = to_picture(messages.colour, messages.depth, *messages.info);
  EXPECT_EQ(cv::norm(received.colour, sent.colour, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(received.depth, sent.depth, cv::NORM_INF), 0.0);
  EXPECT_EQ(received.camera.fx, 500.0);
  EXPECT_EQ(received.camera.fy, 510.0);
  EXPECT_EQ(received.camera.cx, 2.5);
  EXPECT_EQ(received.camera.cy, 1.5);
}

TEST(PictureMessages, DisparityIsADepth) {
  const PictureMessages messages = to_messages(small_picture(), header());
  const auto depth = [&](const stereo_msgs::DisparityImage& disparity) {
    return to_picture(messages.colour, disparity, *messages.info).depth.at<float>(1, 2);
  };
  EXPECT_FLOAT_EQ(depth(disparity_of(25.0F)), 2.0F);
  EXPECT_EQ(depth(disparity_of(0.0F)), 0.0F);
  EXPECT_EQ(depth(disparity_of(-1.0F)), 0.0F);
  EXPECT_EQ(depth(disparity_of(std::nanf(""))), 0.0F);
  stereo_msgs::DisparityImage out_of_search = disparity_of(25.0F);
  out_of_search.min_disparity = 30.0F;
  EXPECT_EQ(depth(out_of_search), 0.0F);
}

TEST(PictureMessages, RefusalsSayWhatIsWrong) {
  PictureMessages messages = to_messages(small_picture(), header());
  const auto open = [&] { to_picture(messages.colour, messages.depth, *messages.info); };
  messages.depth->header.frame_id = "depth_frame";
  EXPECT_NE(refusal(open).find("registered depth is needed"), std::string::npos);
  messages = to_messages(small_picture(), header());
  messages.depth->encoding = "rgb8";
  EXPECT_NE(refusal(open).find("allowed: 16UC1 (mm), 32FC1 (m)"), std::string::npos);
  messages = to_messages(small_picture(), header());
  messages.info->width = 7;
  EXPECT_NE(refusal(open).find("camera_info is for 7 x 4 pixels, the picture has 6 x 4"), std::string::npos);
  messages = to_messages(small_picture(), header());
  messages.colour->data.resize(5);
  EXPECT_NE(refusal(open), "no refusal");
  messages = to_messages(small_picture(), header());
  stereo_msgs::DisparityImage disparity = disparity_of(25.0F);
  disparity.T = 0.0F;
  EXPECT_NE(refusal([&] { to_picture(messages.colour, disparity, *messages.info); }).find("no baseline"),
            std::string::npos);
}

}  // namespace
}  // namespace kinect_ekf_slam
