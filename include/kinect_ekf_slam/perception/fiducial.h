#pragma once

#include <string>
#include <vector>

#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/perception/picture.h"

namespace kinect_ekf_slam {

struct FiducialOptions {
  std::string dictionary = "4X4_50";  ///< OpenCV's name without DICT_
  double side = 0.15;                 ///< m, of the black square
  double corner_sigma = 0.2;          ///< pixels, of each corner on each axis
  double min_side_pixels = 12.0;      ///< of the shortest edge; smaller ones are misread
  double pointing = 2e-3;             ///< rad by which all rays may be off: one pixel
};

/// Finds ArUco fiducials (Garrido-Jurado et al., Pattern Recognition 47(6), 2014) in colour pictures; depth
/// is not needed. A finding's position is the fiducial's centre, its source_id the identity that was read.
///
/// The pose comes from the four corners (Collins and Bartoli, "Infinitesimal plane-based pose estimation",
/// IJCV 109, 2014), the covariance from the corners' noise by the Jacobian of their projection.
class FiducialDetector {
 public:
  /// Throws std::invalid_argument for a dictionary that OpenCV does not have.
  explicit FiducialDetector(const FiducialOptions& options);

  /// Throws PictureError when the picture has no colour or cannot be used.
  Findings detect(const RgbdPicture& picture) const;

 private:
  FiducialOptions options_;
  int dictionary_;
};

/// What is to be printed for an identity: a row of text for each row of modules, hashes black, dots white,
/// the black border with it. Throws std::invalid_argument for a dictionary or an identity that there is not.
std::vector<std::string> fiducial_pattern(const std::string& dictionary, int identity);

}  // namespace kinect_ekf_slam
