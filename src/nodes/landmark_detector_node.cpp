#include "kinect_ekf_slam/ros/landmark_detector_node.h"

#include <tf2_ros/transform_listener.h>

#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/parameter_server.h"

namespace {

constexpr const char* kUsage =
    "usage: landmark_detector_node [NAME:=VALUE ...]\n"
    "\n"
    "Landmarks from pictures, depth and scans, live: a ROS node that needs a master. Its launch files load "
    "the\n"
    "defaults:\n"
    "  roslaunch kinect_ekf_slam detect_kinect_cylinder.launch\n"
    "Other detectors and parameters: README.md, config/detector.yaml.\n"
    "  NAME:=VALUE   remappings, and _group/key:=value for private parameters, as for every ROS node\n"
    "Exit: 0 stopped, 1 a parameter cannot be used (one line says why).\n";

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("landmark_detector_node", kUsage, argc, argv);
  while (words.next()) {
  }
  ros::init(argc, argv, "landmark_detector_node");
  ros::NodeHandle handle;
  ros::NodeHandle private_handle("~");
  try {
    std::vector<std::string> unread;
    const auto options =
        kinect_ekf_slam::read_detector_options(kinect_ekf_slam::parameters_of(private_handle), &unread);
    for (const std::string& line : unread) ROS_WARN("Parameter %s", line.c_str());
    tf2_ros::Buffer transforms;
    const tf2_ros::TransformListener listener(transforms);
    const kinect_ekf_slam::LandmarkDetectorNode node(handle, private_handle, &transforms, options);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
