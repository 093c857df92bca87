#include "kinect_ekf_slam/perception/keypoint_matcher.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

namespace kinect_ekf_slam {
namespace {

/// Descriptors only; of several that want one keypoint, the most similar gets it.
std::vector<cv::DMatch> alike(const Keypoints& first, const Keypoints& second, double ratio) {
  if (first.points.size() < 2 || second.points.size() < 2) return {};
  const bool is_bits = first.descriptors.depth() == CV_8U;
  const cv::BFMatcher matcher(is_bits ? cv::NORM_HAMMING : cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> nearest;
  matcher.knnMatch(first.descriptors, second.descriptors, nearest, 2);
  std::vector<cv::DMatch> candidates;
  for (const std::vector<cv::DMatch>& two : nearest) {
    if (two.size() == 2 && two[0].distance < ratio * two[1].distance) candidates.push_back(two[0]);
  }
  std::stable_sort(candidates.begin(), candidates.end());
  std::vector<bool> taken(second.points.size(), false);
  std::vector<cv::DMatch> matches;
  for (const cv::DMatch& match : candidates) {
    if (taken[match.trainIdx]) continue;
    taken[match.trainIdx] = true;
    matches.push_back(match);
  }
  return matches;
}

}  // namespace

std::vector<KeypointPair> match(const Keypoints& first, const Keypoints& second,
                                const MatchOptions& options) {
  constexpr double kConfidence = 0.999;
  const std::vector<cv::DMatch> matches = alike(first, second, options.ratio);
  const auto fewest = static_cast<std::size_t>(std::max(options.fewest, 8));
  if (matches.size() < fewest) return {};
  std::vector<cv::Point2f> in_first;
  std::vector<cv::Point2f> in_second;
  for (const cv::DMatch& match : matches) {
    in_first.push_back(first.points[match.queryIdx].pt);
    in_second.push_back(second.points[match.trainIdx].pt);
  }
  std::vector<unsigned char> agrees;
  cv::findFundamentalMat(in_first, in_second, cv::FM_RANSAC, options.epipolar_error, kConfidence, agrees);
  std::vector<KeypointPair> pairs;
  for (std::size_t i = 0; i < agrees.size(); ++i) {
    if (agrees[i] != 0) pairs.push_back({matches[i].queryIdx, matches[i].trainIdx});
  }
  if (pairs.size() < fewest) return {};
  return pairs;
}

}  // namespace kinect_ekf_slam
