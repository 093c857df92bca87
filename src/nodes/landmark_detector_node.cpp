#include "kinect_ekf_slam/ros/landmark_detector_node.h"

#include <tf2_ros/transform_listener.h>

#include "kinect_ekf_slam/ros/parameter_server.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "landmark_detector_node");
  ros::NodeHandle handle;
  ros::NodeHandle private_handle("~");
  try {
    std::vector<std::string> unread;
    const auto options =
        kinect_ekf_slam::read_detector_options(kinect_ekf_slam::parameters_of(private_handle), &unread);
    for (const std::string& key : unread)
      ROS_WARN("Parameter %s is not known and was not read.", key.c_str());
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
