#include "kinect_ekf_slam/ros/simulation_bag.h"

#include <rosbag/bag.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "kinect_ekf_slam/ros/picture_messages.h"
#include "kinect_ekf_slam/ros/simulation_messages.h"
#include "kinect_ekf_slam/study/simulated_picture.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kStandingAtEnd = 1.0;  // s
constexpr double kHeadStart = 1e-3;     // s, of what is recorded once

std::string absolute(const std::string& topic) { return "/" + topic; }

class BagWriter {
 public:
  BagWriter(const World& world, std::uint64_t seed, rosbag::Bag* bag)
      : messages_(world, kSimulationStart), camera_(world, seed), delay_(world.gps.delay), bag_(bag) {}

  void write_start(const Sample& sample) {
    // A little before everything else: readers that sort by time must have them first.
    const ros::Time time = messages_.stamp(sample) - ros::Duration(kHeadStart);
    tf2_msgs::TFMessage mountings;
    mountings.transforms = messages_.mountings();
    write_latched("/tf_static", time, mountings);
    write_latched(absolute(simulation_topics::kTrueLandmarks), time, messages_.true_landmarks());
  }

  void write(const Sample& sample) {
    const ros::Time time = messages_.stamp(sample);
    if (sample.gyro_rate_in_imu) {
      bag_->write(absolute(simulation_topics::kImu), time, messages_.imu(sample));
    }
    if (sample.odometry) {
      tf2_msgs::TFMessage transforms;
      transforms.transforms = {messages_.odom_from_base(sample)};
      bag_->write("/tf", time, transforms);
      bag_->write(absolute(simulation_topics::kOdometry), time, messages_.odometry(sample));
      bag_->write(absolute(simulation_topics::kTruePose), time, messages_.true_pose(sample));
    }
    if (sample.sightings) {
      bag_->write(absolute(simulation_topics::kLandmarks), time, messages_.landmarks(sample));
    }
    if (sample.position) {
      const ros::Duration delay(delay_);
      bag_->write(absolute(simulation_topics::kPosition), time + delay, messages_.position(sample));
    }
    if (sample.ranges) bag_->write(absolute(simulation_topics::kRanges), time, messages_.ranges(sample));
    if (sample.takes_picture) {
      const PictureMessages picture =
          to_messages(camera_.take(sample.world_from_base), messages_.optical_header(sample));
      bag_->write(absolute(simulation_topics::kColour), time, picture.colour);
      bag_->write(absolute(simulation_topics::kDepth), time, picture.depth);
      bag_->write(absolute(simulation_topics::kCameraInfo), time, picture.info);
    }
  }

 private:
  /// `rosbag play` latches what was recorded as latched.
  template <class Message>
  void write_latched(const std::string& topic, const ros::Time& time, const Message& message) {
    namespace traits = ros::message_traits;
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["type"] = traits::datatype(message);
    (*header)["md5sum"] = traits::md5sum(message);
    (*header)["message_definition"] = traits::definition(message);
    (*header)["latching"] = "1";
    bag_->write(topic, time, message, header);
  }

  SimulationMessages messages_;
  SimulatedCamera camera_;
  double delay_;  ///< s, of positions
  rosbag::Bag* bag_;
};

/// s; a drive through waypoints that takes longer is stuck.
constexpr double kLongestDrive = 1800.0;

/// Until when there is something to record, s; known only while the robot drives.
double simulate(const SimulationBagRequest& request, rosbag::Bag* bag) {
  Simulator simulator(request.world, request.seed);
  BagWriter writer(request.world, request.seed, bag);
  double end = request.duration;
  for (Sample sample = simulator.next();; sample = simulator.next()) {
    const double now = to_seconds(sample.stamp);
    if (sample.stamp == 0) writer.write_start(sample);
    if (end == 0.0 && simulator.finished()) end = now + kStandingAtEnd;
    if (end > 0.0 && now > end) return end;
    if (end == 0.0 && now > kLongestDrive) {
      throw std::runtime_error("the robot does not reach its last waypoint within " +
                               std::to_string(static_cast<int>(kLongestDrive)) +
                               " s: is a waypoint or the start inside a landmark? (--duration ends a run)");
    }
    writer.write(sample);
    if (request.on_progress && sample.sightings) request.on_progress(now);
  }
}

}  // namespace

double write_simulation_bag(const SimulationBagRequest& request) {
  const std::string partial = request.bag + ".active";  // as rosbag record names what is not complete
  double seconds = 0.0;
  try {
    rosbag::Bag bag;
    bag.open(partial, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::BZ2);
    seconds = simulate(request, &bag);
    bag.close();
  } catch (const rosbag::BagException& error) {
    std::remove(partial.c_str());
    throw std::runtime_error(request.bag + ": cannot be written: " + error.what());
  } catch (const std::runtime_error&) {
    std::remove(partial.c_str());
    throw;
  }
  if (std::rename(partial.c_str(), request.bag.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(partial.c_str());
    throw std::runtime_error(request.bag + ": cannot be written: " + reason);
  }
  return seconds;
}

}  // namespace kinect_ekf_slam
