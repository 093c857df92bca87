#include "kinect_ekf_slam/perception/keypoints.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "kinect_ekf_slam/perception/keypoint_matcher.h"
#include "test/unit/perception/textured.h"

namespace kinect_ekf_slam {
namespace {

using testing::textured_room;

class EveryKeypointType : public ::testing::TestWithParam<KeypointType> {
 protected:
  Keypoints detect(const cv::Mat& colour) const {
    KeypointOptions options;
    options.type = GetParam();
    return KeypointDetector(options).detect(colour);
  }
};

TEST_P(EveryKeypointType, SpreadsOverThePictureAndDescribesEach) {
  const cv::Mat colour = testing::photograph(textured_room(), testing::camera_at(1.0, 0.0)).colour;
  const Keypoints keypoints = detect(colour);
  EXPECT_GT(keypoints.points.size(), 150U);
  EXPECT_LE(keypoints.points.size(), 320U);
  EXPECT_EQ(keypoints.descriptors.rows, static_cast<int>(keypoints.points.size()));
  int quarters[4] = {};
  for (const cv::KeyPoint& point : keypoints.points) {
    ++quarters[(point.pt.x < 320.0F ? 0 : 1) + (point.pt.y < 240.0F ? 0 : 2)];
  }
  for (const int count : quarters) EXPECT_GT(count, 25);
}

TEST_P(EveryKeypointType, APictureWithoutPatternsHasNone) {
  EXPECT_TRUE(detect(cv::Mat(480, 640, CV_8UC3, cv::Scalar(90, 120, 150))).points.empty());
  EXPECT_TRUE(detect(cv::Mat(1, 1, CV_8UC3, cv::Scalar(90, 120, 150))).points.empty());
}

/// Where a pixel of the first picture is in the second: the wall of textured_room() is 3 m ahead.
Eigen::Vector2d moved_along_the_wall(const cv::Point2f& pixel, double to_the_left) {
  const PinholeCamera camera;
  const Eigen::Vector3d point = 3.0 * camera.ray(pixel.x, pixel.y);
  return camera.project(point + Eigen::Vector3d(to_the_left, 0.0, 0.0));
}

TEST_P(EveryKeypointType, PairsOfARenderedWallAgreeWithItsHomography) {
  constexpr double kMove = 0.15;  // m
  Eigen::Isometry3d second_place = testing::camera_at(1.0, 0.0);
  second_place.translation().y() += kMove;
  const Keypoints first =
      detect(testing::photograph(testing::textured_wall(), testing::camera_at(1.0, 0.0), 1).colour);
  const Keypoints second = detect(testing::photograph(testing::textured_wall(), second_place, 2).colour);
  const std::vector<KeypointPair> pairs = match(first, second, {});
  EXPECT_GT(pairs.size(), 60U);
  std::size_t agreeing = 0;
  for (const KeypointPair& pair : pairs) {
    const cv::Point2f seen = second.points[pair.second].pt;
    const Eigen::Vector2d expected = moved_along_the_wall(first.points[pair.first].pt, kMove);
    agreeing += (expected - Eigen::Vector2d(seen.x, seen.y)).norm() < 3.0 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(agreeing), 0.97 * static_cast<double>(pairs.size()));
}

std::string name_of(const ::testing::TestParamInfo<KeypointType>& type) {
  const char* const names[] = {"Harris", "Sift", "Orb", "Akaze"};
  return names[static_cast<int>(type.param)];
}

INSTANTIATE_TEST_SUITE_P(All, EveryKeypointType,
                         ::testing::Values(KeypointType::kHarris, KeypointType::kSift, KeypointType::kOrb,
                                           KeypointType::kAkaze),
                         name_of);

TEST(KeypointMatcher, PicturesOfDifferentThingsHaveNoPairs) {
  const KeypointDetector detector({});
  const auto picture = [&](std::uint64_t pattern) {
    return detector.detect(
        testing::photograph(testing::textured_wall(pattern), testing::camera_at(1.0, 0.0)).colour);
  };
  EXPECT_TRUE(match(picture(1), picture(2), {}).empty());
  EXPECT_TRUE(match(picture(1), {}, {}).empty());
  EXPECT_TRUE(match({}, {}, {}).empty());
}

/// A Kinect on its stand before a table whose objects change: between two pictures nothing moves but these.
TEST(KeypointMatcher, PairsOfRealPicturesAgreeWithOneHomography) {
  const char* data = std::getenv("SLAM_DATA");
  const std::string folder = std::string(data != nullptr ? data : "") + "/kinect_cylinders/";
  const auto read = [&](int number) {
    return cv::imread(folder + "learn" + std::to_string(number) + "_rgb.png");
  };
  if (read(33).empty()) GTEST_SKIP() << "no data: SLAM_DATA/kinect_cylinders";
  int compared = 0;
  for (const KeypointType type : {KeypointType::kOrb, KeypointType::kAkaze}) {
    KeypointOptions options;
    options.type = type;
    const KeypointDetector detector(options);
    Keypoints before = detector.detect(read(33));
    for (int number = 34; number <= 44; ++number) {
      Keypoints now = detector.detect(read(number));
      std::vector<cv::Point2f> in_first;
      std::vector<cv::Point2f> in_second;
      for (const KeypointPair& pair : match(before, now, {})) {
        in_first.push_back(before.points[pair.first].pt);
        in_second.push_back(now.points[pair.second].pt);
      }
      before = std::move(now);
      if (in_first.empty()) continue;  // the stand was moved: too few pairs
      ++compared;
      std::vector<unsigned char> agrees;
      cv::findHomography(in_first, in_second, cv::RANSAC, 3.0, agrees);
      EXPECT_GE(cv::countNonZero(agrees), 0.75 * static_cast<double>(in_first.size())) << number;
    }
  }
  EXPECT_GE(compared, 18);
}

}  // namespace
}  // namespace kinect_ekf_slam
