#include "kinect_ekf_slam/ros/slam_node.h"

#include <tf2_ros/transform_listener.h>

#include "kinect_ekf_slam/ros/parameter_server.h"
#include "kinect_ekf_slam/ros/parameters.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "slam_node");
  ros::NodeHandle handle;
  ros::NodeHandle private_handle("~");
  try {
    const YAML::Node yaml = kinect_ekf_slam::parameters_of(private_handle);
    std::vector<std::string> unread;
    const kinect_ekf_slam::RunOptions options = kinect_ekf_slam::read_parameters(yaml, &unread);
    for (const std::string& key : unread)
      ROS_WARN("Parameter %s is not known and was not read.", key.c_str());
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
