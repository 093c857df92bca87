#pragma once

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

namespace kinect_ekf_slam {

/// SIFT needs OpenCV 4.4. SURF is patented, and distributions' OpenCV has none.
enum class KeypointType { kHarris, kSift, kOrb, kAkaze };

struct KeypointOptions {
  KeypointType type = KeypointType::kOrb;
  int count = 300;     ///< of a picture, at most
  int cell_size = 64;  ///< pixels; the count is spread evenly over cells of this size
};

/// The spots of a picture that can be found again in others, and what each looks like.
struct Keypoints {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;  ///< a row each. CV_8U: bits, compared by the Hamming distance; CV_32F: vectors
};

/// Finds keypoints that are spread over the picture. Harris corners are described by the bits of ORB.
class KeypointDetector {
 public:
  /// Throws std::invalid_argument for a type that this OpenCV does not have.
  explicit KeypointDetector(const KeypointOptions& options);

  /// `colour` is 8UC3. None in a picture of less than 64 pixels on a side.
  Keypoints detect(const cv::Mat& colour) const;

 private:
  std::vector<cv::KeyPoint> spread(std::vector<cv::KeyPoint> points, const cv::Size& size) const;

  KeypointOptions options_;
  cv::Ptr<cv::Feature2D> finder_;
  cv::Ptr<cv::Feature2D> describer_;
};

}  // namespace kinect_ekf_slam
