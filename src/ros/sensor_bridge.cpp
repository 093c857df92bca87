#include "kinect_ekf_slam/ros/sensor_bridge.h"

#include <algorithm>
#include <boost/bind/bind.hpp>
#include <boost/make_shared.hpp>
#include <cmath>
#include <utility>

#include "kinect_ekf_slam/core/one_line.h"
#include "kinect_ekf_slam/ros/conversions.h"

namespace kinect_ekf_slam {
namespace {

/// Messages in a row whose stamps went back before that is taken for a jump of time and not for a bad stamp.
constexpr int kJumpEvidence = 10;
/// s that stamps may leap ahead at once; further needs a second message of about the same time.
constexpr double kLeap = 5.0;
/// s; ROS times end soon after, and adding to them must not throw.
constexpr std::uint32_t kLastSecond = 4000000000U;
/// s of odometry without an IMU message after which the IMU is taken for gone.
constexpr double kImuTimeout = 1.0;

/// Beyond what any detector sends: what stays of a message stays bounded.
constexpr std::size_t kMostDetections = 10000;    // as sensor/max_detections
constexpr std::size_t kLongestLabel = 1000;       // bytes
constexpr std::size_t kLongestDescriptor = 4096;  // numbers

std::string more_than(const std::string& what, std::size_t count, std::size_t most) {
  return what + ": " + std::to_string(count) + " given, allowed: no more than " + std::to_string(most);
}

/// What there is too much of in a message; "": nothing.
std::string excess_of(const LandmarkDetectionArray& message) {
  if (message.detections.size() > kMostDetections)
    return more_than("detections", message.detections.size(), kMostDetections);
  for (const LandmarkDetection& detection : message.detections) {
    if (detection.label.size() > kLongestLabel)
      return more_than("bytes of a label", detection.label.size(), kLongestLabel);
    if (detection.descriptor.size() > kLongestDescriptor)
      return more_than("numbers of a descriptor", detection.descriptor.size(), kLongestDescriptor);
  }
  return "";
}

}  // namespace

SensorBridge::SensorBridge(const FrameOptions& frames, const SyncOptions& sync, TransformLookup lookup,
                           Handlers handlers, const FusionOptions& fusion)
    : frames_(frames),
      sync_(sync),
      fusion_(fusion),
      lookup_(std::move(lookup)),
      handlers_(std::move(handlers)) {
  if (!fusion.datum.empty()) {
    plane_.emplace(Geodetic{fusion.datum[0], fusion.datum[1], fusion.datum[2]});
    datum_is_sure_ = true;
  }
  make_synchronizers();
}

void SensorBridge::make_synchronizers() {
  using boost::placeholders::_2;
  const auto interval = ros::Duration(sync_.max_interval);
  const auto queue = static_cast<std::uint32_t>(sync_.queue_size);
  pairs_ = std::make_unique<message_filters::Synchronizer<Pairs>>(Pairs(queue), odometry_filter_,
                                                                  landmarks_filter_);
  pairs_->setMaxIntervalDuration(interval);
  pairs_->registerCallback(boost::bind(&SensorBridge::on_pair, this, _2));
  triples_ = std::make_unique<message_filters::Synchronizer<Triples>>(Triples(queue), odometry_filter_,
                                                                      landmarks_filter_, imu_filter_);
  triples_->setMaxIntervalDuration(interval);
  triples_->registerCallback(boost::bind(&SensorBridge::on_triple, this, _2));
}

void SensorBridge::reset() {
  for (Input* input :
       {&odometry_input_, &imu_input_, &landmarks_input_, &position_input_, &fix_input_, &ranges_input_}) {
    input->last_stamp = 0;
    input->stamps_before_last = 0;
    input->leap = 0;
  }
  unsynchronized_.clear();
  imu_expected_ = false;
  make_synchronizers();
}

bool SensorBridge::refuse(const Input& input, const std::string& reason, const std::string& detail) {
  ++refusals_[input.name + ": " + reason];
  if (handlers_.on_refusal) handlers_.on_refusal(one_line(input.name + ": message refused, " + detail));
  return false;
}

bool SensorBridge::check_stamp(Input& input, const std_msgs::Header& header, const ros::Time& now) {
  const TimeNs stamp = to_time(header.stamp);
  const std::string at = "stamp " + std::to_string(header.stamp.toSec());
  if (header.stamp.isZero()) return refuse(input, "no stamp", "its stamp is zero");
  if (header.stamp.sec > kLastSecond) return refuse(input, "future", at + " is no time");
  if (!now.isZero() && to_seconds(stamp - to_time(now)) > sync_.future_tolerance) {
    return refuse(input, "future", at + " is ahead of the clock, " + std::to_string(now.toSec()));
  }
  if (input.last_stamp == 0 || stamp > input.last_stamp) {
    if (!confirm_leap(input, stamp)) return refuse(input, "future", at + " is far ahead of the last one");
    input.stamps_before_last = 0;
    return true;
  }
  // The odometry tells, and lasts: a few old messages of any kind are no reason to forget a map.
  const bool behind = &input == &odometry_input_ && (input.stamps_before_last > 0 ||
                                                     to_seconds(input.last_stamp - stamp) > sync_.time_jump);
  if (behind && ++input.stamps_before_last >= kJumpEvidence) {
    reset();
    if (handlers_.on_time_jump) handlers_.on_time_jump();
    return true;
  }
  return stamp == input.last_stamp ? refuse(input, "repeated", at + " came before")
                                   : refuse(input, "old", at + " is older than the last one");
}

bool SensorBridge::confirm_leap(Input& input, TimeNs stamp) const {
  // Ahead of all inputs: detections may well be silent for long while the odometry goes on.
  const TimeNs newest =
      std::max({odometry_input_.last_stamp, imu_input_.last_stamp, landmarks_input_.last_stamp});
  const bool leaps = newest != 0 && to_seconds(stamp - newest) > kLeap;
  const bool confirmed = input.leap != 0 && std::abs(to_seconds(stamp - input.leap)) <= kLeap;
  input.leap = leaps && !confirmed ? stamp : 0;
  return !leaps || confirmed;
}

void SensorBridge::take(Input& input, TimeNs stamp) {
  input.last_stamp = stamp;
  ++accepted_[input.name];
}

std::optional<Eigen::Isometry3d> SensorBridge::base_from(const std::string& frame_id,
                                                         const ros::Time& stamp) const {
  if (frame_id == frames_.base) return Eigen::Isometry3d::Identity();
  if (frame_id.empty() || frame_id.front() == '/') return std::nullopt;  // tf would complain at each look
  return lookup_(frames_.base, frame_id, stamp);
}

bool SensorBridge::add_odometry(const nav_msgs::Odometry::ConstPtr& message, const ros::Time& now) {
  Input& input = odometry_input_;
  const std::string child = without_slash(message->child_frame_id);
  const std::string parent = without_slash(message->header.frame_id);
  if (child != frames_.base || parent != frames_.odom) {
    return refuse(input, "frame",
                  "frames '" + parent + "' -> '" + child + "', expected frames/odom '" + frames_.odom +
                      "' -> frames/base '" + frames_.base + "'");
  }
  SensorFrame frame;
  frame.odometry =
      BodyVelocity{to_eigen(message->twist.twist.linear), to_eigen(message->twist.twist.angular)};
  if (!frame.odometry->linear.allFinite() || !frame.odometry->angular.allFinite() ||
      !is_pose(message->pose.pose)) {
    return refuse(input, "not finite", "pose or twist is not finite, or its quaternion is none");
  }
  frame.stamp = to_time(message->header.stamp) + to_nanoseconds(sync_.odometry_delay);
  if (!message->header.stamp.isZero() && frame.stamp <= 0) {
    return refuse(input, "no stamp", "its stamp and input/odometry_delay give a time before zero");
  }
  if (!check_stamp(input, message->header, now)) return false;
  take(input, to_time(message->header.stamp));

  nav_msgs::Odometry::ConstPtr delayed = message;
  if (sync_.odometry_delay != 0.0) {
    auto copy = boost::make_shared<nav_msgs::Odometry>(*message);
    copy->header.stamp = to_ros(frame.stamp);
    delayed = copy;
  }
  if (imu_expected_ && to_seconds(input.last_stamp - imu_input_.last_stamp) > kImuTimeout) {
    refuse(imu_input_, "silent", "none came any more; going on without");
    imu_expected_ = false;
  }
  handlers_.on_frame(std::move(frame));
  odometry_filter_.add(ros::MessageEvent<nav_msgs::Odometry const>(delayed, now));
  return true;
}

bool SensorBridge::add_imu(const sensor_msgs::Imu::ConstPtr& message, const ros::Time& now) {
  Input& input = imu_input_;
  const Eigen::Vector3d rate_in_imu = to_eigen(message->angular_velocity);
  if (message->angular_velocity_covariance[0] == -1.0) {
    return refuse(input, "no rates", "it says that it has no angular velocity (covariance[0] = -1)");
  }
  if (!rate_in_imu.allFinite()) {
    return refuse(input, "not finite", "its angular velocity is not finite");
  }
  if (!check_stamp(input, message->header, now)) return false;
  const std::string frame_id = without_slash(message->header.frame_id);
  const auto base_from_imu = base_from(frame_id, message->header.stamp);
  if (!base_from_imu) {
    return refuse(input, "no transform", "no tf from '" + frame_id + "' to '" + frames_.base + "'");
  }
  take(input, to_time(message->header.stamp));
  SensorFrame frame;
  frame.stamp = to_time(message->header.stamp);
  frame.gyro_rate = base_from_imu->linear() * rate_in_imu;
  imu_expected_ = true;
  handlers_.on_frame(std::move(frame));
  imu_filter_.add(ros::MessageEvent<sensor_msgs::Imu const>(message, now));
  return true;
}

bool SensorBridge::add_landmarks(const LandmarkDetectionArray::ConstPtr& message, const ros::Time& now) {
  Input& input = landmarks_input_;
  if (message->header.frame_id.empty()) {
    return refuse(input, "frame", "its frame_id is empty");
  }
  if (const std::string excess = excess_of(*message); !excess.empty()) {
    return refuse(input, "too large", excess);
  }
  if (!check_stamp(input, message->header, now)) return false;
  take(input, to_time(message->header.stamp));
  unsynchronized_.push_back(input.last_stamp);
  if (unsynchronized_.size() > static_cast<std::size_t>(sync_.queue_size)) {
    unsynchronized_.pop_front();
    refuse(input, "unsynchronized", "no odometry (or IMU) within sync/max_interval of it");
  }
  landmarks_filter_.add(ros::MessageEvent<LandmarkDetectionArray const>(message, now));
  return true;
}

void SensorBridge::on_pair(const LandmarkDetectionArray::ConstPtr& message) {
  if (!imu_expected_) on_synchronized(message);
}

void SensorBridge::on_triple(const LandmarkDetectionArray::ConstPtr& message) {
  if (imu_expected_) on_synchronized(message);
}

std::optional<Eigen::Isometry3d> SensorBridge::admit(Input& input, const std_msgs::Header& header,
                                                     const std::string& sensor,
                                                     const std::optional<MessageProblem>& problem,
                                                     const ros::Time& now) {
  if (problem) {
    refuse(input, problem->reason, problem->detail);
    return std::nullopt;
  }
  if (!check_stamp(input, header, now)) return std::nullopt;
  auto base_from_sensor = base_from(sensor, header.stamp);
  if (!base_from_sensor) {
    refuse(input, "no transform", "no tf from '" + sensor + "' to '" + frames_.base + "'");
    return std::nullopt;
  }
  take(input, to_time(header.stamp));
  return base_from_sensor;
}

bool SensorBridge::add_position(const geometry_msgs::PoseWithCovarianceStamped& message,
                                const ros::Time& now) {
  const std::string frame_id = without_slash(message.header.frame_id);
  if (frame_id != frames_.map && frame_id != fusion_.frame) {
    return refuse(position_input_, "frame",
                  "its frame is '" + frame_id + "', expected frames/map '" + frames_.map +
                      "' or fusion/frame '" + fusion_.frame + "'");
  }
  const std::string antenna = fusion_.antenna_frame.empty() ? frames_.base : fusion_.antenna_frame;
  const auto base_from_antenna =
      admit(position_input_, message.header, antenna, problem_of(message.pose), now);
  if (!base_from_antenna) return false;
  SensorFrame frame;
  frame.stamp = to_time(message.header.stamp);
  (frame_id == frames_.map ? frame.position : frame.global_position) =
      to_position(message.pose, *base_from_antenna);
  handlers_.on_frame(std::move(frame));
  return true;
}

bool SensorBridge::add_fix(const sensor_msgs::NavSatFix& message, const ros::Time& now) {
  const Geodetic place{message.latitude, message.longitude, message.altitude};
  std::optional<MessageProblem> problem = problem_of(message, fusion_.fix_sigma);
  if (!problem && plane_) {
    problem = problem_of_distance((*plane_)(place));
    if (problem && !datum_is_sure_) {  // one of the two is wrong: the next fix tells which
      problem->detail += "; the datum is now this fix, as none agreed with the last";
      plane_.emplace(place);
    }
  }
  const auto base_from_antenna =
      admit(fix_input_, message.header, without_slash(message.header.frame_id), problem, now);
  if (!base_from_antenna) return false;
  if (!plane_) {
    plane_.emplace(place);
    return true;
  }
  datum_is_sure_ = true;
  SensorFrame frame;
  frame.stamp = to_time(message.header.stamp);
  frame.global_position = to_position(message, *plane_, *base_from_antenna, fusion_.fix_sigma);
  handlers_.on_frame(std::move(frame));
  return true;
}

bool SensorBridge::add_ranges(const BeaconRanges& message, const ros::Time& now) {
  const auto base_from_receiver =
      admit(ranges_input_, message.header, without_slash(message.header.frame_id), std::nullopt, now);
  if (!base_from_receiver) return false;
  SensorFrame frame;
  frame.stamp = to_time(message.header.stamp);
  frame.ranges = to_ranges(message, *base_from_receiver);
  handlers_.on_frame(std::move(frame));
  return true;
}

std::optional<Pose3d> SensorBridge::initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const std::string frame_id = without_slash(message.header.frame_id);
  std::optional<MessageProblem> problem = problem_of_initial_pose(message.pose);
  if (frame_id != frames_.map) {
    problem =
        MessageProblem{"frame", "its frame is '" + frame_id + "', expected frames/map '" + frames_.map + "'"};
  }
  if (problem) {
    refuse(initial_pose_input_, problem->reason, problem->detail);
    return std::nullopt;
  }
  ++accepted_[initial_pose_input_.name];
  return to_initial_pose(message.pose);
}

void SensorBridge::on_synchronized(const LandmarkDetectionArray::ConstPtr& message) {
  Input& input = landmarks_input_;
  const TimeNs stamp = to_time(message->header.stamp);
  while (!unsynchronized_.empty() && unsynchronized_.front() < stamp) {
    unsynchronized_.pop_front();
    refuse(input, "unsynchronized", "no odometry (or IMU) within sync/max_interval of it");
  }
  if (unsynchronized_.empty() || unsynchronized_.front() != stamp) return;  // a pair before, now a triple
  unsynchronized_.pop_front();

  const std::string frame_id = without_slash(message->header.frame_id);
  const auto base_from_sensor = base_from(frame_id, message->header.stamp);
  if (!base_from_sensor) {
    refuse(input, "no transform", "no tf from '" + frame_id + "' to '" + frames_.base + "'");
    return;
  }
  SensorFrame frame;
  frame.stamp = stamp;
  frame.detections.emplace();
  frame.detections->reserve(message->detections.size());
  for (const LandmarkDetection& detection : message->detections) {
    frame.detections->push_back(to_detection(detection, *base_from_sensor, is_optical(frame_id)));
  }
  handlers_.on_frame(std::move(frame));
}

}  // namespace kinect_ekf_slam
