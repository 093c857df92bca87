#include "kinect_ekf_slam/perception/keypoints.h"

#include <algorithm>
#include <opencv2/core/version.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "kinect_ekf_slam/core/compatibility.h"

namespace kinect_ekf_slam {
namespace {

constexpr int kSpare = 5;  // times as many candidates as are kept, so that every part of the picture has some

cv::Ptr<cv::Feature2D> make_sift() {
#if KINECT_EKF_SLAM_HAS_SIFT
  return cv::SIFT::create(0, 3, 0.02);
#else
  throw std::invalid_argument("features/type sift: this OpenCV is older than 4.4 and has none");
#endif
}

cv::Ptr<cv::Feature2D> make_orb(int count) {
  constexpr float kPyramidScale = 1.2F;
  constexpr int kLevels = 8;
  constexpr int kBorder = 31;         // pixels
  constexpr int kFastThreshold = 10;  // grey levels
  return cv::ORB::create(count, kPyramidScale, kLevels, kBorder, 0, 2, cv::ORB::HARRIS_SCORE, kBorder,
                         kFastThreshold);
}

cv::Ptr<cv::Feature2D> make_harris(int count) {
  constexpr double kQuality = 1e-4;  // of the best corner's response
  constexpr double kDistance = 7.0;  // pixels between corners
  constexpr int kWindow = 5;         // pixels
  return cv::GFTTDetector::create(count, kQuality, kDistance, kWindow, true);
}

cv::Ptr<cv::Feature2D> make_akaze() {
  auto akaze = cv::AKAZE::create();
  akaze->setThreshold(5e-4);
  return akaze;
}

}  // namespace

KeypointDetector::KeypointDetector(const KeypointOptions& options) : options_(options) {
  const int candidates = kSpare * options.count;
  switch (options.type) {
    case KeypointType::kHarris:
      finder_ = make_harris(candidates);
      describer_ = make_orb(candidates);
      break;
    case KeypointType::kSift:
      finder_ = describer_ = make_sift();
      break;
    case KeypointType::kOrb:
      finder_ = describer_ = make_orb(candidates);
      break;
    case KeypointType::kAkaze:
      finder_ = describer_ = make_akaze();
      break;
  }
}

Keypoints KeypointDetector::detect(const cv::Mat& colour) const {
  constexpr int kSmallest = 64;  // pixels; the detectors' pyramids need some
  if (colour.rows < kSmallest || colour.cols < kSmallest) return {};
  cv::Mat grey;
  cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> candidates;
  finder_->detect(grey, candidates);
  Keypoints keypoints;
  keypoints.points = spread(std::move(candidates), grey.size());
  if (!keypoints.points.empty()) describer_->compute(grey, keypoints.points, keypoints.descriptors);
  return keypoints;
}

/// The strongest of each cell, as many from one as from another.
std::vector<cv::KeyPoint> KeypointDetector::spread(std::vector<cv::KeyPoint> points,
                                                   const cv::Size& size) const {
  std::stable_sort(points.begin(), points.end(), [](const cv::KeyPoint& left, const cv::KeyPoint& right) {
    return left.response > right.response;
  });
  const int columns = (size.width - 1) / options_.cell_size + 1;
  const int rows = (size.height - 1) / options_.cell_size + 1;
  const int most = (options_.count - 1) / (columns * rows) + 1;
  std::vector<int> counts(static_cast<std::size_t>(columns) * rows, 0);
  std::vector<cv::KeyPoint> kept;
  for (const cv::KeyPoint& point : points) {
    const auto column = static_cast<std::size_t>(point.pt.x) / options_.cell_size;
    const auto row = static_cast<std::size_t>(point.pt.y) / options_.cell_size;
    if (counts[row * columns + column]++ < most) kept.push_back(point);
  }
  return kept;
}

}  // namespace kinect_ekf_slam
