#include "kinect_ekf_slam/ros/detector_options.h"

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/ros/parameter_visitor.h"

namespace kinect_ekf_slam {
namespace {

void visit_inputs(ParameterVisitor& v, DetectorOptions& o) {
  v.text("input/colour_topic", &o.colour_topic, false, "sensor_msgs/Image, rectified");
  v.text("input/depth_topic", &o.depth_topic, false, "sensor_msgs/Image, registered to the colour");
  v.text("input/info_topic", &o.info_topic, false, "sensor_msgs/CameraInfo of the colour");
  v.text("input/scan_topic", &o.scan_topic, false, "sensor_msgs/LaserScan");
  v.text("input/level_frame", &o.level_frame, true, "a tf frame whose Z points up, as a prior for the floor");
  v.number("input/max_interval", &o.max_interval, 1e-3, 10.0, "s", "between the messages of one picture");
  v.integer("input/queue_size", &o.queue_size, 1, 1000, "messages", "that wait for their partners");
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
  if (!(o.radius.min < o.radius.max)) {
    throw ParameterError("kinect_cylinder/min_radius: " + text_of(o.radius.min) +
                         " given, allowed: less than kinect_cylinder/max_radius, " + text_of(o.radius.max));
  }
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
  if (!(o.radius.min < o.radius.max)) {
    throw ParameterError("laser_cylinder/min_radius: " + text_of(o.radius.min) +
                         " given, allowed: less than laser_cylinder/max_radius, " + text_of(o.radius.max));
  }
}

void visit(ParameterVisitor& v, FiducialOptions& o) {
  v.text("aruco/dictionary", &o.dictionary, false, "OpenCV's name without DICT_, for example 4X4_50");
  v.number("aruco/side", &o.side, 1e-3, 10.0, "m", "of the black square");
  v.number("aruco/corner_sigma", &o.corner_sigma, 1e-3, 10.0, "pixels", "of each corner");
  v.number("aruco/min_side_pixels", &o.min_side_pixels, 4.0, 1000.0, "pixels",
           "smaller ones are not trusted");
}

}  // namespace

DetectorOptions read_detector_options(const YAML::Node& yaml, std::vector<std::string>* unread) {
  DetectorOptions options;
  ParameterVisitor visitor(&yaml);
  visitor.choice<DetectorType>("detector/type", &options.type,
                               {{"kinect_cylinder", DetectorType::kKinectCylinder},
                                {"laser_cylinder", DetectorType::kLaserCylinder},
                                {"aruco", DetectorType::kAruco}},
                               "what is looked for, and with which sensor");
  visitor.text("detector/palette", &options.palette, true,
               "file with the names of the colours; empty: no labels");
  visit_inputs(visitor, options);
  visit(visitor, options.kinect_cylinder);
  visit(visitor, options.laser_cylinder);
  visit(visitor, options.fiducial);
  if (unread != nullptr) *unread = visitor.unread();
  return options;
}

}  // namespace kinect_ekf_slam
