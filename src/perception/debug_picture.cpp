#include "kinect_ekf_slam/perception/debug_picture.h"

#include <algorithm>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>

namespace kinect_ekf_slam {
namespace {

const cv::Scalar kGreen(60, 220, 60);
const cv::Scalar kRed(60, 60, 230);

void frame(const Region& region, const std::string& text, const cv::Scalar& colour, cv::Mat* picture) {
  cv::rectangle(*picture, {region.left, region.top, region.width, region.height}, colour, 1);
  const cv::Point place(region.left, std::max(12, region.top - 4));
  cv::putText(*picture, text, place, cv::FONT_HERSHEY_SIMPLEX, 0.4, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(*picture, text, place, cv::FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv::LINE_AA);
}

std::string describe(const Finding& finding) {
  char text[64];
  const Signature& signature = finding.signature;
  if (signature.source_id != kNoId) {
    std::snprintf(text, sizeof(text), "%d at %.2f m", signature.source_id, finding.position.z());
  } else {
    std::snprintf(text, sizeof(text), "r %.3f at %.2f m, %.1f", signature.radius, finding.position.z(),
                  finding.score);
  }
  return signature.label.empty() ? text : signature.label + " " + text;
}

}  // namespace

cv::Mat draw_findings(const cv::Mat& colour, const Findings& findings) {
  cv::Mat picture = colour.clone();
  for (const Refusal& refusal : findings.refused) frame(refusal.region, refusal.reason, kRed, &picture);
  for (const Finding& finding : findings.found) frame(finding.region, describe(finding), kGreen, &picture);
  return picture;
}

}  // namespace kinect_ekf_slam
