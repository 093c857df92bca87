#pragma once

#include <optional>
#include <variant>

#include "kinect_ekf_slam/ros/detector_options.h"

namespace kinect_ekf_slam {

/// The detector of pictures that `detector/type` names.
class PictureDetector {
 public:
  /// Throws std::runtime_error when the palette cannot be used, std::invalid_argument for a dictionary or a
  /// type of keypoints that OpenCV does not have, and for a type that looks at no pictures.
  explicit PictureDetector(const DetectorOptions& options);

  /// Pictures come in the order of time. `up_in_optical`: where up is, if that is known. Throws PictureError.
  Findings detect(const RgbdPicture& picture, const std::optional<Eigen::Vector3d>& up_in_optical);

  /// Takes other options of the same type; what the detector remembers stays. Throws as the constructor does.
  void set_options(const DetectorOptions& options);

 private:
  Palette palette_;
  std::variant<std::monostate, KinectCylinderDetector, FiducialDetector, FeatureDetector> detector_;
};

}  // namespace kinect_ekf_slam
