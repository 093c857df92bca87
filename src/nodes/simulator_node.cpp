#include "kinect_ekf_slam/ros/simulator_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "simulator_node");
  ros::NodeHandle handle;
  ros::NodeHandle private_handle("~");
  try {
    const auto options = kinect_ekf_slam::read_simulator_node_options(private_handle);
    const kinect_ekf_slam::SimulatorNode node(handle, private_handle, options);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
