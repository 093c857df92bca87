#include "kinect_ekf_slam/ros/simulator_node.h"

#include "kinect_ekf_slam/ros/command_line.h"

namespace {

constexpr const char* kUsage =
    "usage: simulator_node [NAME:=VALUE ...]\n"
    "\n"
    "A simulated robot in a room, live: a ROS node that needs a master. With slam_node beside it:\n"
    "  roslaunch kinect_ekf_slam simulation.launch [world:=FILE.yaml] [drive:=cmd_vel] [rviz:=true]\n"
    "  NAME:=VALUE   remappings, and _name:=value for private parameters: those in simulation.launch\n"
    "Exit: 0 stopped, 1 a parameter or world cannot be used (one line says why).\n";

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("simulator_node", kUsage, argc, argv);
  while (words.next()) {
  }
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
