#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "kinect_ekf_slam/perception/feature.h"
#include "kinect_ekf_slam/perception/fiducial.h"
#include "kinect_ekf_slam/perception/kinect_cylinder.h"
#include "kinect_ekf_slam/perception/laser_cylinder.h"

namespace kinect_ekf_slam {

enum class DetectorType { kKinectCylinder, kLaserCylinder, kAruco, kFeatures };
/// Where the depth of pictures comes from.
enum class DepthSource { kDepth, kDisparity };

/// The parameters of landmark_detector_node; config/detector.yaml shows them.
struct DetectorOptions {
  DetectorType type = DetectorType::kKinectCylinder;
  std::string colour_topic = "camera/rgb/image_rect_color";
  std::string depth_topic = "camera/depth_registered/image_raw";
  std::string disparity_topic = "stereo/disparity";
  DepthSource depth_source = DepthSource::kDepth;
  std::string info_topic = "camera/rgb/camera_info";
  std::string scan_topic = "scan";
  std::string level_frame;     ///< a frame whose Z points up; empty: there is none
  double max_interval = 0.02;  ///< s, between colour, depth and camera_info of one picture
  int queue_size = 5;
  std::string palette;  ///< file
  KinectCylinderOptions kinect_cylinder;
  LaserCylinderOptions laser_cylinder;
  FiducialOptions fiducial;
  FeatureOptions features;
};

/// Reads the options from the groups of `yaml`; `unread` gets a line for each key that nothing reads. Throws
/// ParameterError for an unknown name, a value out of range or of another type.
DetectorOptions read_detector_options(const YAML::Node& yaml, std::vector<std::string>* unread);

}  // namespace kinect_ekf_slam
