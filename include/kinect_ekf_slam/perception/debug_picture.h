#pragma once

#include <opencv2/core.hpp>

#include "kinect_ekf_slam/perception/findings.h"

namespace kinect_ekf_slam {

/// The picture with a green frame round what was found, and a red one, with the reason, round what was
/// refused.
cv::Mat draw_findings(const cv::Mat& colour, const Findings& findings);

}  // namespace kinect_ekf_slam
