#include "kinect_ekf_slam/ros/simulator_node.h"

#include <rosgraph_msgs/Clock.h>

#include <cmath>
#include <stdexcept>

#include "kinect_ekf_slam/ros/conversions.h"
#include "kinect_ekf_slam/ros/picture_messages.h"
#include "kinect_ekf_slam/ros/simulation_bag.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kTick = 0.005;          // s of wall time
constexpr double kCommandTimeout = 0.5;  // s
constexpr std::uint32_t kQueue = 100;
constexpr double kLongestDuration = 1e6;  // s
constexpr double kLargestFactor = 100.0;
constexpr double kLargestPictureRate = 1000.0;  // Hz

[[noreturn]] void fail(const std::string& key, const std::string& given, const std::string& allowed) {
  throw std::runtime_error("~" + key + ": '" + given + "' given, allowed: " + allowed);
}

double number(const ros::NodeHandle& handle, const std::string& key, double value, double low, double high) {
  if (handle.hasParam(key) && !handle.getParam(key, value)) fail(key, "not a number", "a number");
  if (!(value >= low && value <= high)) {
    fail(key, std::to_string(value), "from " + std::to_string(low) + " to " + std::to_string(high));
  }
  return value;
}

World world_of(const SimulatorNodeOptions& options) {
  World world = read_world(options.world);
  if (options.picture_rate) world.pictures.rate = *options.picture_rate;
  return world;
}

/// The clock that others see; the run's own one when this node makes the time.
ros::Time first_stamp(bool publishes_clock) {
  if (publishes_clock) return to_ros(kSimulationStart);
  ros::Time::waitForValid();
  return ros::Time::now();
}

}  // namespace

SimulatorNodeOptions read_simulator_node_options(const ros::NodeHandle& private_handle) {
  SimulatorNodeOptions options;
  if (!private_handle.getParam("world", options.world)) {
    fail("world", "nothing", "the path of a world file, for example config/worlds/room.yaml");
  }
  int seed = 1;
  if (private_handle.hasParam("seed") && (!private_handle.getParam("seed", seed) || seed < 0)) {
    fail("seed", std::to_string(seed), "a whole number, not negative");
  }
  options.seed = static_cast<std::uint64_t>(seed);
  const auto drive = private_handle.param<std::string>("drive", "waypoints");
  if (drive != "waypoints" && drive != "cmd_vel") fail("drive", drive, "waypoints, cmd_vel");
  options.by_command = drive == "cmd_vel";
  options.duration = number(private_handle, "duration", options.duration, 0.0, kLongestDuration);
  options.rate_factor = number(private_handle, "rate_factor", options.rate_factor, 0.01, kLargestFactor);
  options.publish_clock = private_handle.param("publish_clock", false);
  if (options.rate_factor != 1.0 && !options.publish_clock) {
    fail("rate_factor", std::to_string(options.rate_factor), "1 unless ~publish_clock is true");
  }
  if (private_handle.hasParam("picture_rate")) {
    options.picture_rate = number(private_handle, "picture_rate", 0.0, 0.0, kLargestPictureRate);
  }
  return options;
}

SimulatorNode::SimulatorNode(ros::NodeHandle handle, ros::NodeHandle private_handle,
                             const SimulatorNodeOptions& options)
    : options_(options),
      simulator_(world_of(options), options.seed),
      camera_(simulator_.world(), options.seed),
      wall_start_(ros::WallTime::now()),
      start_(first_stamp(options.publish_clock)),
      messages_(simulator_.world(), to_time(start_)) {
  namespace topics = simulation_topics;
  odometry_publisher_ = handle.advertise<nav_msgs::Odometry>(topics::kOdometry, kQueue);
  imu_publisher_ = handle.advertise<sensor_msgs::Imu>(topics::kImu, kQueue);
  landmarks_publisher_ = handle.advertise<LandmarkDetectionArray>(topics::kLandmarks, kQueue);
  if (simulator_.world().gps.rate > 0.0) {
    position_publisher_ =
        handle.advertise<geometry_msgs::PoseWithCovarianceStamped>(topics::kPosition, kQueue);
  }
  if (simulator_.world().beacons.rate > 0.0) {
    ranges_publisher_ = handle.advertise<BeaconRanges>(topics::kRanges, kQueue);
  }
  true_pose_publisher_ = handle.advertise<geometry_msgs::PoseStamped>(topics::kTruePose, kQueue);
  true_landmarks_publisher_ = handle.advertise<LandmarkMap>(topics::kTrueLandmarks, 1, true);
  markers_publisher_ = private_handle.advertise<visualization_msgs::MarkerArray>("markers", 1, true);
  if (simulator_.world().pictures.rate > 0.0) advertise_pictures(handle);
  if (options_.publish_clock) clock_publisher_ = handle.advertise<rosgraph_msgs::Clock>("/clock", kQueue);
  if (options_.by_command) {
    simulator_.set_command({});
    command_subscriber_ = handle.subscribe(topics::kCommand, 1, &SimulatorNode::on_command, this);
  }
  publish_once();
  next_ = simulator_.next();
  timer_ =
      handle.createWallTimer(ros::WallDuration(kTick), [this](const ros::WallTimerEvent&) { on_tick(); });
}

void SimulatorNode::advertise_pictures(const ros::NodeHandle& handle) {
  namespace topics = simulation_topics;
  constexpr std::uint32_t kPictures = 5;
  image_transport::ImageTransport transport(handle);
  colour_publisher_ = transport.advertise(topics::kColour, kPictures);
  depth_publisher_ = transport.advertise(topics::kDepth, kPictures);
  info_publisher_ =
      ros::NodeHandle(handle).advertise<sensor_msgs::CameraInfo>(topics::kCameraInfo, kPictures);
}

TimeNs SimulatorNode::due() const {
  if (!options_.publish_clock) return to_time(ros::Time::now()) - to_time(start_);
  return to_nanoseconds((ros::WallTime::now() - wall_start_).toSec() * options_.rate_factor);
}

void SimulatorNode::on_command(const geometry_msgs::Twist& command) {
  const Eigen::Vector3d rates = to_eigen(command.angular);
  if (!std::isfinite(command.linear.x) || !rates.allFinite()) {
    ROS_WARN_THROTTLE(5.0, "%s: command refused, it is not finite", simulation_topics::kCommand);
    return;
  }
  BodyVelocity velocity;
  velocity.linear.x() = command.linear.x;
  velocity.angular = rates;
  simulator_.set_command(velocity);
  last_command_ = next_.stamp;
}

void SimulatorNode::on_tick() {
  const TimeNs now = due();
  while (next_.stamp <= now) {
    if (options_.duration > 0.0 && to_seconds(next_.stamp) > options_.duration) {
      ROS_INFO("Simulated %.1f s; done.", options_.duration);
      timer_.stop();
      ros::requestShutdown();
      return;
    }
    if (options_.by_command && to_seconds(next_.stamp - last_command_) > kCommandTimeout) {
      simulator_.set_command({});
    }
    publish(next_);
    next_ = simulator_.next();
  }
  if (!arrived_ && simulator_.finished()) {
    arrived_ = true;
    ROS_INFO("The robot stands at its last waypoint.");
  }
}

void SimulatorNode::publish(const Sample& sample) {
  if (options_.publish_clock) {
    rosgraph_msgs::Clock clock;
    clock.clock = messages_.stamp(sample);
    clock_publisher_.publish(clock);
  }
  if (sample.gyro_rate_in_imu) imu_publisher_.publish(messages_.imu(sample));
  if (sample.odometry) {
    transform_broadcaster_.sendTransform(messages_.odom_from_base(sample));
    odometry_publisher_.publish(messages_.odometry(sample));
    true_pose_publisher_.publish(messages_.true_pose(sample));
  }
  if (sample.sightings) landmarks_publisher_.publish(messages_.landmarks(sample));
  if (sample.position) delayed_positions_.push_back(messages_.position(sample));
  const ros::Time taken = messages_.stamp(sample) - ros::Duration(simulator_.world().gps.delay);
  while (!delayed_positions_.empty() && delayed_positions_.front().header.stamp <= taken) {
    position_publisher_.publish(delayed_positions_.front());
    delayed_positions_.pop_front();
  }
  if (sample.ranges) ranges_publisher_.publish(messages_.ranges(sample));
  if (sample.takes_picture) publish_picture(sample);
}

void SimulatorNode::publish_picture(const Sample& sample) {
  const PictureMessages picture =
      to_messages(camera_.take(sample.world_from_base), messages_.optical_header(sample));
  colour_publisher_.publish(picture.colour);
  depth_publisher_.publish(picture.depth);
  info_publisher_.publish(picture.info);
}

void SimulatorNode::publish_once() {
  static_broadcaster_.sendTransform(messages_.mountings());
  true_landmarks_publisher_.publish(messages_.true_landmarks());
  markers_publisher_.publish(messages_.markers());
}

}  // namespace kinect_ekf_slam
