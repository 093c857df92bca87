#include "kinect_ekf_slam/ros/picture_detector.h"

#include <stdexcept>

namespace kinect_ekf_slam {

PictureDetector::PictureDetector(const DetectorOptions& options) {
  if (!options.palette.empty()) palette_ = read_palette(options.palette);
  set_options(options);
}

Findings PictureDetector::detect(const RgbdPicture& picture,
                                 const std::optional<Eigen::Vector3d>& up_in_optical) {
  if (auto* cylinders = std::get_if<KinectCylinderDetector>(&detector_)) {
    return cylinders->detect(picture, up_in_optical);
  }
  if (auto* fiducials = std::get_if<FiducialDetector>(&detector_)) return fiducials->detect(picture);
  return std::get<FeatureDetector>(detector_).detect(picture);
}

void PictureDetector::set_options(const DetectorOptions& options) {
  switch (options.type) {
    case DetectorType::kKinectCylinder:
      detector_.emplace<KinectCylinderDetector>(options.kinect_cylinder, palette_);
      break;
    case DetectorType::kAruco:
      detector_.emplace<FiducialDetector>(options.fiducial);
      break;
    case DetectorType::kFeatures:
      if (auto* features = std::get_if<FeatureDetector>(&detector_)) {
        features->set_options(options.features);
      } else {
        detector_.emplace<FeatureDetector>(options.features);
      }
      break;
    case DetectorType::kLaserCylinder:
      throw std::invalid_argument("detector/type: laser_cylinder looks at scans, not at pictures");
  }
}

}  // namespace kinect_ekf_slam
