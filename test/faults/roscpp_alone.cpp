/// Nothing of the package: hears tf as slam_node does, publishes, answers and logs. What ThreadSanitizer
/// reports of it is of ROS's own libraries, which are not built with it. Beside a roscore, built by
/// scripts/build_sanitized.sh thread:
///   export TSAN_OPTIONS="suppressions=$PWD/test/faults/thread_sanitizer.txt print_suppressions=1"
///   build/thread/devel/env.sh roscpp_alone
/// tells at its end how often it needed each suppression. Meanwhile publish tf at some hundred Hz, let
/// subscribers of `said` come and go, and call `asked` again and again.
#include <ros/ros.h>
#include <std_srvs/Empty.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

bool answer(std_srvs::Empty::Request& /*request*/, std_srvs::Empty::Response& /*response*/) { return true; }

int main(int argc, char** argv) {
  ros::init(argc, argv, "roscpp_alone");
  ros::NodeHandle handle;
  tf2_ros::Buffer buffer;
  const tf2_ros::TransformListener listener(buffer);
  const ros::Publisher said = handle.advertise<tf2_msgs::TFMessage>("said", 10);
  tf2_msgs::TFMessage message;
  message.transforms.resize(100);
  const auto publish = [&](const ros::WallTimerEvent&) {
    said.publish(message);
    ROS_INFO_THROTTLE(1.0, "published");
  };
  const ros::ServiceServer asked = handle.advertiseService("asked", answer);
  const ros::WallTimer timer = handle.createWallTimer(ros::WallDuration(0.01), publish);
  ros::spin();
}
