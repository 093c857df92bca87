// Plays a recorded run to a slam_node as it happened and tells how soon the node answers, and what it costs.
//   benchmark_node BAG PID     PID: the slam_node's process
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "kinect_ekf_slam/AssociationArray.h"
#include "kinect_ekf_slam/LandmarkDetectionArray.h"

namespace {

using kinect_ekf_slam::AssociationArray;
using kinect_ekf_slam::LandmarkDetectionArray;
using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// User and system seconds of a process so far (man 5 proc: fields 14 and 15).
double cpu_seconds(const std::string& pid) {
  std::ifstream stat("/proc/" + pid + "/stat");
  std::string line;
  std::getline(stat, line);
  unsigned long user = 0, system = 0;
  std::sscanf(line.c_str() + std::min(line.rfind(')') + 1, line.size()),
              " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu", &user, &system);
  return static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// When what was sent, and how long the answers took. The answer to detections comes when the last message
/// that the node's synchroniser waits for has come, whichever that is: time is counted from there.
class Answers {
 public:
  void sent_input() {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_sent_ = Clock::now();
  }
  void sent_odometry(const ros::Time& stamp) {
    const std::lock_guard<std::mutex> lock(mutex_);
    odometry_sent_[stamp] = last_sent_ = Clock::now();
  }
  void on_associations(const AssociationArray::ConstPtr& /*message*/) {
    const std::lock_guard<std::mutex> lock(mutex_);
    detections_.push_back(milliseconds_since(last_sent_));
  }
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped::ConstPtr& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto sent = odometry_sent_.find(message->header.stamp);
    if (sent != odometry_sent_.end()) odometry_.push_back(milliseconds_since(sent->second));
  }
  void print() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::printf("                          answers   median       99 %%    worst (ms)\n");
    print("detections to landmarks", &detections_);
    print("odometry to pose", &odometry_);
  }

 private:
  static void print(const char* what, std::vector<double>* times) {
    if (times->empty()) {
      std::printf("%-24s        none\n", what);
      return;
    }
    std::sort(times->begin(), times->end());
    const auto quantile = [&](double share) {
      return (*times)[static_cast<std::size_t>(share * static_cast<double>(times->size() - 1))];
    };
    std::printf("%-24s %8zu %8.3f %10.3f %8.3f\n", what, times->size(), quantile(0.5), quantile(0.99),
                quantile(1.0));
  }

  std::mutex mutex_;
  Clock::time_point last_sent_;
  std::map<ros::Time, Clock::time_point> odometry_sent_;
  std::vector<double> detections_, odometry_;
};

void play(rosbag::Bag* bag, Answers* answers) {
  ros::NodeHandle handle;
  const auto odometry = handle.advertise<nav_msgs::Odometry>("odom", 100);
  const auto imu = handle.advertise<sensor_msgs::Imu>("imu", 100);
  const auto landmarks = handle.advertise<LandmarkDetectionArray>("landmarks", 100);
  const auto mountings = handle.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
  while (ros::ok() &&
         odometry.getNumSubscribers() * landmarks.getNumSubscribers() * imu.getNumSubscribers() == 0)
    ros::WallDuration(0.05).sleep();

  rosbag::View view(
      *bag, rosbag::TopicQuery({"odom", "/odom", "imu", "/imu", "landmarks", "/landmarks", "/tf_static"}));
  const auto start = Clock::now();
  for (const rosbag::MessageInstance& message : view) {
    std::this_thread::sleep_until(
        start + std::chrono::nanoseconds((message.getTime() - view.getBeginTime()).toNSec()));
    if (!ros::ok()) return;
    if (const auto of_odometry = message.instantiate<nav_msgs::Odometry>()) {
      answers->sent_odometry(of_odometry->header.stamp);
      odometry.publish(of_odometry);
    } else if (const auto of_imu = message.instantiate<sensor_msgs::Imu>()) {
      answers->sent_input();
      imu.publish(of_imu);
    } else if (const auto of_landmarks = message.instantiate<LandmarkDetectionArray>()) {
      answers->sent_input();
      landmarks.publish(of_landmarks);
    } else if (const auto of_mountings = message.instantiate<tf2_msgs::TFMessage>()) {
      mountings.publish(of_mountings);
      ros::WallDuration(0.5).sleep();
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "benchmark_node");
  if (argc != 3) {
    std::fprintf(stderr, "usage: benchmark_node BAG PID\n");
    return 2;
  }
  Answers answers;
  ros::NodeHandle handle;
  const auto hints = ros::TransportHints().tcpNoDelay();
  const auto associations =
      handle.subscribe("slam_node/associations", 100, &Answers::on_associations, &answers, hints);
  const auto poses = handle.subscribe("slam_node/pose", 100, &Answers::on_pose, &answers, hints);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  try {
    rosbag::Bag bag(argv[1]);
    const double cpu = cpu_seconds(argv[2]);
    const auto start = Clock::now();
    play(&bag, &answers);
    const double elapsed = 1e-3 * milliseconds_since(start);
    spinner.stop();
    answers.print();
    std::printf("slam_node took %.1f %% of one core over %.0f s\n",
                100.0 * (cpu_seconds(argv[2]) - cpu) / elapsed, elapsed);
  } catch (const rosbag::BagException& error) {
    std::fprintf(stderr, "benchmark_node: %s: %s\n", argv[1], error.what());
    return 2;
  }
  return 0;
}
