#include "kinect_ekf_slam/ros/detector_options.h"

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/ros/parameter_visitor.h"

namespace kinect_ekf_slam {
namespace {

void visit_inputs(ParameterVisitor& v, DetectorOptions& o) {
  v.text("input/colour_topic", &o.colour_topic, false, "sensor_msgs/Image, rectified");
  v.text("input/depth_topic", &o.depth_topic, false, "sensor_msgs/Image, registered to the colour");
  v.choice<DepthSource>("input/depth_source", &o.depth_source,
                        {{"depth", DepthSource::kDepth}, {"disparity", DepthSource::kDisparity}},
                        "a depth picture, or the disparity of a stereo camera");
  v.text("input/disparity_topic", &o.disparity_topic, false,
         "stereo_msgs/DisparityImage of the left camera, whose picture is the colour");
  v.text("input/info_topic", &o.info_topic, false, "sensor_msgs/CameraInfo of the colour");
  v.text("input/scan_topic", &o.scan_topic, false, "sensor_msgs/LaserScan");
  v.text("input/level_frame", &o.level_frame, true, "a tf frame whose Z points up, as a prior for the floor");
  v.number("input/max_interval", &o.max_interval, 1e-3, 10.0, "s", "between the messages of one picture");
  v.integer("input/queue_size", &o.queue_size, 1, 1000, "messages", "that wait for their partners");
}

/// Bounds that leave nothing between them are refused.
void check_order(const std::string& group, const std::string& what, double min, double max) {
  if (min < max) return;
  throw ParameterError(group + "/min_" + what + ": " + text_of(min) + " given, allowed: less than " + group +
                       "/max_" + what + ", " + text_of(max));
}

void visit(ParameterVisitor& v, KinectCylinderOptions& o) {
  double min_arc_deg = degrees(o.min_arc);
  v.number("kinect_cylinder/min_depth", &o.min_depth, 0.1, 20.0, "m", "nearer readings are not used");
  v.number("kinect_cylinder/max_depth", &o.max_depth, 0.1, 20.0, "m", "farther readings are not used");
  v.number("kinect_cylinder/min_radius", &o.radius.min, 0.005, 1.0, "m", "of a cylinder");
  v.number("kinect_cylinder/max_radius", &o.radius.max, 0.01, 1.0, "m", "of a cylinder");
  v.number("kinect_cylinder/min_height", &o.min_height, 0.01, 5.0, "m", "above the floor or table");
  v.number("kinect_cylinder/max_height", &o.max_height, 0.02, 5.0, "m", "above the floor or table");
  v.number("kinect_cylinder/min_arc_deg", &min_arc_deg, 10.0, 180.0, "deg", "of its wall that must be seen");
  v.number("kinect_cylinder/max_misfit", &o.max_misfit, 0.1, 100.0, "-",
           "mean squared residual over its variance");
  v.number("kinect_cylinder/max_taper", &o.max_taper, 0.0, 10.0, "-", "change of radius over height");
  v.integer("kinect_cylinder/stride", &o.stride, 1, 8, "pixels", "every so many are looked at");
  o.min_arc = radians(min_arc_deg);
  check_order("kinect_cylinder", "radius", o.radius.min, o.radius.max);
  check_order("kinect_cylinder", "depth", o.min_depth, o.max_depth);
  check_order("kinect_cylinder", "height", o.min_height, o.max_height);
}

void visit(ParameterVisitor& v, LaserCylinderOptions& o) {
  double min_arc_deg = degrees(o.min_arc);
  v.number("laser_cylinder/min_radius", &o.radius.min, 0.005, 5.0, "m", "of a cylinder");
  v.number("laser_cylinder/max_radius", &o.radius.max, 0.01, 5.0, "m", "of a cylinder");
  v.number("laser_cylinder/range_sigma", &o.range_sigma, 1e-6, 1.0, "m", "of the scanner");
  v.number("laser_cylinder/jump", &o.jump, 1e-3, 10.0, "m", "between neighbouring ranges: another surface");
  v.integer("laser_cylinder/min_points", &o.min_points, 3, 1000, "rays", "that must meet it");
  v.number("laser_cylinder/min_arc_deg", &min_arc_deg, 10.0, 180.0, "deg", "of its wall that must be seen");
  v.number("laser_cylinder/max_misfit", &o.max_misfit, 0.1, 100.0, "-",
           "mean squared residual over its variance");
  o.min_arc = radians(min_arc_deg);
  check_order("laser_cylinder", "radius", o.radius.min, o.radius.max);
}

void visit(ParameterVisitor& v, FiducialOptions& o) {
  v.text("aruco/dictionary", &o.dictionary, false, "OpenCV's name without DICT_, for example 4X4_50");
  v.number("aruco/side", &o.side, 1e-3, 10.0, "m", "of the black square");
  v.number("aruco/corner_sigma", &o.corner_sigma, 1e-3, 10.0, "pixels", "of each corner");
  v.number("aruco/min_side_pixels", &o.min_side_pixels, 4.0, 1000.0, "pixels",
           "smaller ones are not trusted");
}

void visit(ParameterVisitor& v, FeatureOptions& o) {
  v.choice<KeypointType>("features/type", &o.keypoints.type,
                         {{"orb", KeypointType::kOrb},
                          {"harris", KeypointType::kHarris},
                          {"sift", KeypointType::kSift},
                          {"akaze", KeypointType::kAkaze}},
                         "of the keypoints");
  v.integer("features/count", &o.keypoints.count, 8, 5000, "-", "keypoints of a picture, at most");
  v.integer("features/cell_size", &o.keypoints.cell_size, 8, 4096, "pixels",
            "over whose cells they are spread");
  v.number("features/ratio", &o.matching.ratio, 0.1, 1.0, "-", "of the best to the second best match");
  v.number("features/epipolar_error", &o.matching.epipolar_error, 0.1, 100.0, "pixels",
           "of a match, at most");
  v.number("features/reprojection_error", &o.two_views.reprojection_error, 0.1, 100.0, "pixels",
           "RANSAC's bound for what moves with the camera only");
  v.number("features/pixel_sigma", &o.two_views.pixel_sigma, 0.01, 100.0, "pixels", "of a keypoint");
  v.integer("features/min_sightings", &o.min_sightings, 2, 1000, "pictures", "before a feature is reported");
  v.integer("features/most", &o.most, 1, 1000, "-", "that are reported of a picture");
  v.integer("features/remembered_keyframes", &o.remembered_keyframes, 0, 10000, "pictures",
            "in which lost features are looked for");
  v.number("features/min_depth", &o.min_depth, 0.01, 100.0, "m", "nearer readings are not used");
  v.number("features/max_depth", &o.max_depth, 0.1, 100.0, "m", "farther readings are not used");
  check_order("features", "depth", o.min_depth, o.max_depth);
  v.number(
      "features/depth_sigma_per_m", &o.noise.sigma_per_m, 1e-6, 1.0, "1/m",
      "sigma of a depth over its square; of a stereo camera: that of its disparity over f times baseline");
  v.number("features/depth_step_per_m", &o.noise.step_per_m, 0.0, 1.0, "1/m", "its step likewise");
}

}  // namespace

DetectorOptions read_detector_options(const YAML::Node& yaml, std::vector<std::string>* unread) {
  DetectorOptions options;
  ParameterVisitor visitor(&yaml);
  visitor.choice<DetectorType>("detector/type", &options.type,
                               {{"kinect_cylinder", DetectorType::kKinectCylinder},
                                {"laser_cylinder", DetectorType::kLaserCylinder},
                                {"aruco", DetectorType::kAruco},
                                {"features", DetectorType::kFeatures}},
                               "what is looked for, and with which sensor");
  visitor.text("detector/palette", &options.palette, true,
               "file with the names of the colours; empty: no labels");
  visit_inputs(visitor, options);
  visit(visitor, options.kinect_cylinder);
  visit(visitor, options.laser_cylinder);
  visit(visitor, options.fiducial);
  visit(visitor, options.features);
  if (unread != nullptr) *unread = visitor.unread();
  return options;
}

}  // namespace kinect_ekf_slam
