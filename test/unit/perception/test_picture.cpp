#include "kinect_ekf_slam/perception/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

RgbdPicture good() {
  RgbdPicture picture;
  picture.colour = cv::Mat(4, 6, CV_8UC3, cv::Scalar(1, 2, 3));
  picture.depth = cv::Mat(4, 6, CV_16UC1, cv::Scalar(1500));
  return picture;
}

TEST(Picture, AcceptsMillimetresMetresAndEitherAlone) {
  RgbdPicture picture = good();
  EXPECT_NO_THROW(check(picture));
  picture.depth = cv::Mat(4, 6, CV_32FC1, cv::Scalar(1.5));
  EXPECT_NO_THROW(check(picture));
  picture.colour = cv::Mat();
  EXPECT_NO_THROW(check(picture));
  picture = good();
  picture.depth = cv::Mat();
  EXPECT_NO_THROW(check(picture));
}

TEST(Picture, RefusesWhatNoDetectorCanUse) {
  RgbdPicture picture = good();
  picture.depth = cv::Mat(4, 6, CV_8UC1);
  EXPECT_THROW(check(picture), PictureError);
  picture = good();
  picture.colour = cv::Mat(4, 6, CV_8UC1);
  EXPECT_THROW(check(picture), PictureError);
  picture = good();
  picture.depth = cv::Mat(2, 3, CV_16UC1);
  EXPECT_THROW(check(picture), PictureError);
  EXPECT_THROW(check(RgbdPicture()), PictureError);
  for (const double bad : {0.0, -1.0, 1e-300, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    picture = good();
    picture.camera.fx = bad;
    EXPECT_THROW(check(picture), PictureError) << bad;
  }
  for (const double bad : {-1e300, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    picture = good();
    picture.camera.cy = bad;
    EXPECT_THROW(check(picture), PictureError) << bad;
  }
}

TEST(Picture, DepthIsInMetresAndNanWhereThereIsNone) {
  const cv::Mat millimetres = (cv::Mat_<std::uint16_t>(1, 2) << 1500, 0);
  const cv::Mat from_millimetres = depth_in_metres(millimetres);
  EXPECT_FLOAT_EQ(from_millimetres.at<float>(0), 1.5F);
  EXPECT_TRUE(std::isnan(from_millimetres.at<float>(1)));
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const cv::Mat metres = (cv::Mat_<float>(1, 4) << 1.5F, 0.0F, -1.0F, kInfinity);
  const cv::Mat from_metres = depth_in_metres(metres);
  EXPECT_FLOAT_EQ(from_metres.at<float>(0), 1.5F);
  for (int i = 1; i < 4; ++i) EXPECT_TRUE(std::isnan(from_metres.at<float>(i)));
}

TEST(Camera, ProjectsAlongItsRays) {
  const PinholeCamera camera{500.0, 510.0, 300.0, 200.0};
  const Eigen::Vector2d pixel = camera.project(2.5 * camera.ray(123.0, 45.0));
  EXPECT_TRUE(testing::MatrixNear(pixel, Eigen::Vector2d(123.0, 45.0), 1e-9));
}

}  // namespace
}  // namespace kinect_ekf_slam
