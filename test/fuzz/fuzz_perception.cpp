/// Damaged messages through the whole of perception, built with AddressSanitizer: what cannot be used is
/// refused with a reason, what can be used gives finite findings, and nothing reads where it must not.
/// FUZZ_ROUNDS says how many pictures.
#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/ros/detector_messages.h"
#include "kinect_ekf_slam/ros/picture_detector.h"
#include "kinect_ekf_slam/ros/picture_messages.h"

extern "C" const char* __asan_default_options() {  // NOLINT(bugprone-reserved-identifier): ASan's name
  return "detect_leaks=0";                         // what other libraries keep until the end is not ours
}

namespace kinect_ekf_slam {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

int rounds() {
  const char* given = std::getenv("FUZZ_ROUNDS");
  return given != nullptr ? std::atoi(given) : 400;
}

/// The messages of one picture. Depth and disparity alike are its second image.
struct Messages {
  sensor_msgs::ImagePtr colour;
  sensor_msgs::ImagePtr depth;
  sensor_msgs::CameraInfoPtr info;
  stereo_msgs::DisparityImage disparity;
};

Messages sound(RandomStream* random) {
  RgbdPicture picture;
  picture.colour.create(kHeight, kWidth, CV_8UC3);
  picture.depth.create(kHeight, kWidth, CV_16UC1);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto shade = static_cast<std::uint8_t>(40 * ((row / 8 + column / 8) % 5) + random->index(30));
      picture.colour.at<cv::Vec3b>(row, column) = {shade, static_cast<std::uint8_t>(200 - shade), 40};
      picture.depth.at<std::uint16_t>(row, column) = row < 50 ? 2000 : 500 * kHeight / (row - 30);
    }
  }
  picture.camera = {130.0, 130.0, 79.5, 59.5};
  const PictureMessages messages = to_messages(picture, std_msgs::Header());
  stereo_msgs::DisparityImage disparity;
  disparity.f = 130.0F;
  disparity.T = 0.1F;
  return {messages.colour, messages.depth, messages.info, disparity};
}

std::string any_encoding(RandomStream* random) {
  const char* const encodings[] = {"bgr8",  "rgb8",   "bgra8",  "mono8",       "mono16", "16UC1", "32FC1",
                                   "64FC1", "32FC77", "yuv422", "bayer_rggb8", "",       "purple"};
  return encodings[random->index(std::size(encodings))];
}

double any_number(RandomStream* random) {
  const double numbers[] = {0.0,
                            -1.0,
                            1e-300,
                            1e300,
                            std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity(),
                            random->uniform(-1000.0, 1000.0)};
  return numbers[random->index(std::size(numbers))];
}

void damage(RandomStream* random, sensor_msgs::Image* image) {
  switch (random->index(8)) {
    case 0:
      image->width = static_cast<std::uint32_t>(random->index(2 * kWidth));
      break;
    case 1:
      image->height = static_cast<std::uint32_t>(random->index(2 * kHeight));
      break;
    case 2:
      image->step = static_cast<std::uint32_t>(random->index(8 * kWidth));
      break;
    case 3:
      image->encoding = any_encoding(random);
      break;
    case 4:
      image->data.resize(random->index(2 * image->data.size() + 1));
      break;
    case 5:  // all the same: zeros, or NaN where the pixels are floats
      std::memset(image->data.data(), random->chance(0.5) ? 0 : 0xFF, image->data.size());
      break;
    case 6:
      for (std::uint8_t& byte : image->data) byte = static_cast<std::uint8_t>(random->index(256));
      break;
    default:
      image->is_bigendian = 1;
      break;
  }
}

void damage(RandomStream* random, sensor_msgs::CameraInfo* info) {
  switch (random->index(4)) {
    case 0:
      info->width = static_cast<std::uint32_t>(random->index(1000));
      break;
    case 1:
      info->P[random->index(info->P.size())] = any_number(random);
      break;
    case 2:
      info->K.assign(any_number(random));
      info->P.assign(any_number(random));
      break;
    default:
      info->D.assign(random->index(20), any_number(random));
      info->distortion_model = random->chance(0.5) ? "purple" : "rational_polynomial";
      break;
  }
}

void damage(RandomStream* random, Messages* messages) {
  const std::size_t count = random->index(4);
  for (std::size_t i = 0; i < count; ++i) {
    switch (random->index(4)) {
      case 0:
        damage(random, messages->colour.get());
        break;
      case 1:
        damage(random, messages->depth.get());
        break;
      case 2:
        damage(random, messages->info.get());
        break;
      default:
        messages->disparity.f = static_cast<float>(any_number(random));
        messages->disparity.T = random->chance(0.5) ? 0.1F : static_cast<float>(any_number(random));
        break;
    }
  }
}

RgbdPicture open(DetectorType type, bool is_stereo, Messages* messages) {
  if (type == DetectorType::kAruco) return to_picture(messages->colour, *messages->info);
  if (!is_stereo) return to_picture(messages->colour, messages->depth, *messages->info);
  if (messages->depth->encoding == "16UC1") {  // the same bytes as floats
    messages->depth->encoding = "32FC1";
    messages->depth->data.resize(2 * messages->depth->data.size(), 0x3F);
    messages->depth->step *= 2;
  }
  messages->disparity.image = *messages->depth;
  return to_picture(messages->colour, messages->disparity, *messages->info);
}

class DamagedMessages : public ::testing::TestWithParam<DetectorType> {};

TEST_P(DamagedMessages, AreRefusedWithAReasonOrGiveFiniteFindings) {
  DetectorOptions options;
  options.type = GetParam();
  options.features.remembered_keyframes = 3;  // comparing with many takes its time
  PictureDetector detector(options);
  int used = 0;
  int refused = 0;
  for (int i = 0; i < rounds(); ++i) {
    RandomStream random(static_cast<std::uint64_t>(i), 0);
    Messages messages = sound(&random);
    damage(&random, &messages);
    try {
      const RgbdPicture picture = open(options.type, random.chance(0.3), &messages);
      for (const Finding& finding : detector.detect(picture, std::nullopt).found) {
        EXPECT_TRUE(finding.position.allFinite()) << i;
        EXPECT_TRUE(finding.covariance.allFinite()) << i;
      }
      ++used;
    } catch (const std::exception& reason) {
      EXPECT_FALSE(std::string(reason.what()).empty()) << i;
      ++refused;
    }
  }
  EXPECT_GT(used, rounds() / 10);
  EXPECT_GT(refused, rounds() / 10);
}

INSTANTIATE_TEST_SUITE_P(EveryDetector, DamagedMessages,
                         ::testing::Values(DetectorType::kKinectCylinder, DetectorType::kAruco,
                                           DetectorType::kFeatures));

/// A cylinder before a wall.
sensor_msgs::LaserScan sound_scan(RandomStream* random) {
  constexpr int kRays = 360;
  sensor_msgs::LaserScan scan;
  scan.angle_min = -1.57F;
  scan.angle_increment = 3.14F / kRays;
  scan.range_min = 0.1F;
  scan.range_max = 5.0F;
  for (int ray = 0; ray < kRays; ++ray) {
    const double angle = scan.angle_min + ray * scan.angle_increment;
    const double across = 1.5 * std::sin(angle);  // m, of the ray from an axis 1.5 m ahead
    const double radius = 0.12;
    const bool meets = std::abs(across) < radius;
    const double range = meets ? 1.5 * std::cos(angle) - std::sqrt(radius * radius - across * across) : 3.0;
    scan.ranges.push_back(static_cast<float>(range + random->normal() * 0.003));
  }
  return scan;
}

void damage(RandomStream* random, sensor_msgs::LaserScan* scan) {
  float* const numbers[] = {&scan->angle_min, &scan->angle_increment, &scan->range_min, &scan->range_max};
  switch (random->index(4)) {
    case 0:
      *numbers[random->index(std::size(numbers))] = static_cast<float>(any_number(random));
      break;
    case 1:
      scan->ranges.resize(random->index(2 * scan->ranges.size() + 1));
      break;
    case 2:
      for (float& range : scan->ranges) {
        if (random->chance(0.2)) range = static_cast<float>(any_number(random));
      }
      break;
    default:
      scan->ranges.assign(scan->ranges.size(), static_cast<float>(any_number(random)));
      break;
  }
}

TEST(DamagedScans, AreRefusedWithAReasonOrGiveFiniteFindings) {
  constexpr int kScans = 10000;
  std::size_t found = 0;
  int refused = 0;
  for (int i = 0; i < kScans; ++i) {
    RandomStream random(static_cast<std::uint64_t>(i), 0);
    sensor_msgs::LaserScan scan = sound_scan(&random);
    for (std::size_t times = random.index(4); times > 0; --times) damage(&random, &scan);
    try {
      const Findings findings = find_cylinders(to_scan(scan), LaserCylinderOptions());
      for (const Finding& finding : findings.found) {
        EXPECT_TRUE(finding.position.allFinite()) << i;
        EXPECT_TRUE(finding.covariance.allFinite()) << i;
      }
      found += findings.found.size();
    } catch (const std::runtime_error& reason) {
      EXPECT_FALSE(std::string(reason.what()).empty()) << i;
      ++refused;
    }
  }
  EXPECT_GT(found, kScans / 10U);
  EXPECT_GT(refused, kScans / 100);
}

}  // namespace
}  // namespace kinect_ekf_slam
