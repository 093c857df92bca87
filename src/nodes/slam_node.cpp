#include "kinect_ekf_slam/ros/slam_node.h"

#include <tf2_ros/transform_listener.h>

#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/parameter_server.h"
#include "kinect_ekf_slam/ros/parameters.h"

namespace {

constexpr const char* kUsage =
    "usage: slam_node [NAME:=VALUE ...]\n"
    "\n"
    "Landmark SLAM, live: a ROS node that needs a master. Its launch file loads the defaults:\n"
    "  roslaunch kinect_ekf_slam slam.launch [config:=FILE.yaml] [rviz:=true]\n"
    "Topics, services and parameters: README.md, or `slam_replay --parameters`.\n"
    "  NAME:=VALUE   remappings, and _group/key:=value for private parameters, as for every ROS node\n"
    "Exit: 0 stopped, 1 a parameter or map cannot be used (one line says why).\n";

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("slam_node", kUsage, argc, argv);
  while (words.next()) {
  }
  ros::init(argc, argv, "slam_node");
  ros::NodeHandle handle;
  ros::NodeHandle private_handle("~");
  try {
    const YAML::Node yaml = kinect_ekf_slam::parameters_of(private_handle);
    std::vector<std::string> unread;
    const kinect_ekf_slam::RunOptions options = kinect_ekf_slam::read_parameters(yaml, &unread);
    for (const std::string& line : unread) ROS_WARN("Parameter %s", line.c_str());
    ROS_INFO("Parameters:\n%s", options.text.c_str());

    tf2_ros::Buffer transforms(ros::Duration(60.0));
    const tf2_ros::TransformListener listener(transforms);
    kinect_ekf_slam::SlamNode node(handle, private_handle, &transforms, options);
    ros::spin();
    node.shut_down();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
