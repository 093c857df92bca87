#include "kinect_ekf_slam/ros/sensor_bridge.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <limits>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using Counts = std::map<std::string, std::uint64_t>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A bridge, what came out of it, and messages to put in.
class Bridge : public ::testing::Test {
 protected:
  void SetUp() override {
    ros::Time::init();  // message_filters asks for a clock
    frames_.base = "base_link";
    make();
  }

  void make() {
    SensorBridge::Handlers handlers;
    handlers.on_frame = [this](SensorFrame frame) { frames_out_.push_back(std::move(frame)); };
    handlers.on_time_jump = [this] { ++jumps_; };
    handlers.on_refusal = [this](const std::string& line) { lines_.push_back(line); };
    const auto lookup = [this](const std::string& target, const std::string& source, const ros::Time&) {
      EXPECT_FALSE(source.empty() || source.front() == '/')
          << "tf does not like to be asked for '" << source << "'";
      const auto known = transforms_.find(source);
      const bool found = target == "base_link" && known != transforms_.end();
      return found ? std::make_optional(known->second) : std::nullopt;
    };
    bridge_ = std::make_unique<SensorBridge>(frames_, sync_, lookup, handlers, fusion_);
  }

  static nav_msgs::Odometry odometry_message(double time) {
    nav_msgs::Odometry message;
    message.header.stamp = ros::Time(time);
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    message.pose.pose.orientation.w = 1.0;
    message.twist.twist.linear.x = 0.1;
    return message;
  }
  static sensor_msgs::Imu imu_message(double time) {
    sensor_msgs::Imu message;
    message.header.stamp = ros::Time(time);
    message.header.frame_id = "base_link";
    message.angular_velocity.z = 0.3;
    return message;
  }
  static LandmarkDetectionArray landmarks_message(double time) {
    LandmarkDetectionArray message;
    message.header.stamp = ros::Time(time);
    message.header.frame_id = "base_link";
    message.detections.resize(1);
    message.detections[0].position.x = 1.0;
    return message;
  }

  bool add(const nav_msgs::Odometry& message, double now = 0.0) {
    return bridge_->add_odometry(boost::make_shared<nav_msgs::Odometry>(message), ros::Time(now));
  }
  bool add(const sensor_msgs::Imu& message, double now = 0.0) {
    return bridge_->add_imu(boost::make_shared<sensor_msgs::Imu>(message), ros::Time(now));
  }
  bool add(const LandmarkDetectionArray& message, double now = 0.0) {
    return bridge_->add_landmarks(boost::make_shared<LandmarkDetectionArray>(message), ros::Time(now));
  }
  static geometry_msgs::PoseWithCovarianceStamped position_message(double time) {
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.stamp = ros::Time(time);
    message.header.frame_id = "map";
    message.pose.pose.orientation.w = 1.0;
    message.pose.pose.position.x = 7.0;
    for (const std::size_t i : {0U, 7U, 14U}) message.pose.covariance[i] = 0.25;
    return message;
  }
  static sensor_msgs::NavSatFix fix_message(double time) {
    sensor_msgs::NavSatFix message;
    message.header.stamp = ros::Time(time);
    message.header.frame_id = "/gps_link";
    message.latitude = 42.0;
    message.longitude = -71.0;
    for (const std::size_t i : {0U, 4U, 8U}) message.position_covariance[i] = 1.0;
    message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
    return message;
  }
  bool add(const geometry_msgs::PoseWithCovarianceStamped& message) {
    return bridge_->add_position(message, ros::Time());
  }
  bool add(const sensor_msgs::NavSatFix& message) { return bridge_->add_fix(message, ros::Time()); }
  bool odometry(double time, double now = 0.0) { return add(odometry_message(time), now); }
  bool imu(double time, double now = 0.0) { return add(imu_message(time), now); }
  bool landmarks(double time, double now = 0.0) { return add(landmarks_message(time), now); }

  int looks() const {
    int count = 0;
    for (const SensorFrame& frame : frames_out_) count += frame.detections ? 1 : 0;
    return count;
  }
  Counts refusals() const { return bridge_->refusals(); }

  FrameOptions frames_;
  SyncOptions sync_;
  FusionOptions fusion_;
  std::map<std::string, Eigen::Isometry3d> transforms_;
  std::unique_ptr<SensorBridge> bridge_;
  std::vector<SensorFrame> frames_out_;
  std::vector<std::string> lines_;
  int jumps_ = 0;
};

TEST_F(Bridge, TurnsMessagesIntoFrames) {
  nav_msgs::Odometry message = odometry_message(1.0);
  message.twist.twist.angular.z = -0.4;
  EXPECT_TRUE(add(message));
  ASSERT_EQ(frames_out_.size(), 1U);
  EXPECT_EQ(frames_out_[0].stamp, 1000000000);
  EXPECT_EQ(frames_out_[0].odometry->linear.x(), 0.1);
  EXPECT_EQ(frames_out_[0].odometry->angular.z(), -0.4);
  EXPECT_FALSE(frames_out_[0].detections);
  EXPECT_EQ(bridge_->accepted(), (Counts{{"odometry", 1}}));
}

TEST_F(Bridge, APositionIsInTheMapOrInTheFrameOfGlobalOnes) {
  EXPECT_TRUE(add(position_message(1.0)));
  ASSERT_TRUE(frames_out_.back().position);
  EXPECT_EQ(frames_out_.back().position->position_in_map.x(), 7.0);
  EXPECT_FALSE(frames_out_.back().position->map_from_base);  // no angle has a covariance
  auto global = position_message(2.0);
  global.header.frame_id = "earth";
  global.pose.covariance[35] = 0.01;
  EXPECT_TRUE(add(global));
  ASSERT_TRUE(frames_out_.back().global_position);
  EXPECT_TRUE(frames_out_.back().global_position->map_from_base);
}

TEST_F(Bridge, SaysWhatIsWrongWithAPosition) {
  auto elsewhere = position_message(1.0);
  elsewhere.header.frame_id = "utm";
  EXPECT_FALSE(add(elsewhere));
  EXPECT_EQ(lines_.back(),
            "global_position: message refused, its frame is 'utm', expected frames/map 'map' or fusion/frame "
            "'earth'");
  auto sure = position_message(1.0);
  sure.pose.covariance.fill(0.0);
  EXPECT_FALSE(add(sure));
  EXPECT_EQ(lines_.back(),
            "global_position: message refused, its covariance is all zero: how sure the position is must be "
            "told");
  EXPECT_TRUE(add(position_message(3.0)));
  EXPECT_FALSE(add(position_message(2.0)));
  EXPECT_EQ(lines_.back(), "global_position: message refused, stamp 2.000000 is older than the last one");
  EXPECT_EQ(refusals(), (Counts{{"global_position: frame", 1},
                                {"global_position: no covariance", 1},
                                {"global_position: old", 1}}));
}

TEST_F(Bridge, SaysThatTheAntennasFrameIsNotInTf) {
  fusion_.antenna_frame = "prism";
  make();
  EXPECT_FALSE(add(position_message(1.0)));
  EXPECT_EQ(lines_.back(), "global_position: message refused, no tf from 'prism' to 'base_link'");
  EXPECT_EQ(refusals(), (Counts{{"global_position: no transform", 1}}));
}

TEST_F(Bridge, AFixIsEastAndNorthOfTheFirstOne) {
  transforms_["gps_link"] = Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(add(fix_message(1.0)));
  EXPECT_TRUE(frames_out_.empty());  // whether it can be trusted the second one tells
  auto north = fix_message(2.0);
  north.latitude += 1e-4;
  EXPECT_TRUE(add(north));
  EXPECT_TRUE(add(fix_message(3.0)));
  ASSERT_EQ(frames_out_.size(), 2U);
  EXPECT_TRUE(
      MatrixNear(frames_out_[0].global_position->position_in_map, Eigen::Vector3d(0.0, 11.107, 0.0), 1e-3));
  EXPECT_TRUE(
      MatrixNear(frames_out_[0].global_position->antenna_in_base, Eigen::Vector3d(0.1, 0.2, 0.3), 0.0));
  EXPECT_TRUE(MatrixNear(frames_out_[1].global_position->position_in_map, Eigen::Vector3d::Zero(), 1e-9));
}

TEST_F(Bridge, AWrongFirstFixIsNotTheDatumForLong) {
  transforms_["gps_link"] = Eigen::Isometry3d::Identity();
  auto wrong = fix_message(1.0);
  wrong.latitude = wrong.longitude = 0.0;
  EXPECT_TRUE(add(wrong));
  EXPECT_FALSE(add(fix_message(2.0)));
  EXPECT_EQ(
      lines_.back(),
      "fix: message refused, it is 7844 km from the datum, allowed: 100 km; see fusion/datum; the datum "
      "is now this fix, as none agreed with the last");
  EXPECT_TRUE(add(fix_message(3.0)));
  ASSERT_EQ(frames_out_.size(), 1U);  // no fix was told as of a datum that is none
  EXPECT_TRUE(MatrixNear(frames_out_[0].global_position->position_in_map, Eigen::Vector3d::Zero(), 1e-9));
}

TEST_F(Bridge, TheDatumStaysOnceASecondFixAgreed) {
  transforms_["gps_link"] = Eigen::Isometry3d::Identity();
  for (const double time : {1.0, 2.0}) EXPECT_TRUE(add(fix_message(time)));
  for (const double time : {3.0, 4.0}) {
    auto wrong = fix_message(time);
    wrong.latitude = wrong.longitude = 0.0;
    EXPECT_FALSE(add(wrong));
  }
  EXPECT_TRUE(add(fix_message(5.0)));
  ASSERT_EQ(frames_out_.size(), 2U);
  EXPECT_TRUE(MatrixNear(frames_out_[1].global_position->position_in_map, Eigen::Vector3d::Zero(), 1e-9));
}

TEST_F(Bridge, AFixIsEastAndNorthOfTheDatum) {
  transforms_["gps_link"] = Eigen::Isometry3d::Identity();
  fusion_.datum = {42.0 - 1e-4, -71.0, 0.0};
  make();
  EXPECT_TRUE(add(fix_message(1.0)));
  EXPECT_NEAR(frames_out_[0].global_position->position_in_map.y(), 11.107, 1e-3);
}

TEST_F(Bridge, RefusesAFixFarFromTheDatum) {
  transforms_["gps_link"] = Eigen::Isometry3d::Identity();
  fusion_.datum = {42.0 - 0.8, -71.0, 0.0};
  make();
  EXPECT_TRUE(add(fix_message(1.0)));
  fusion_.datum = {42.0 - 1.0, -71.0, 0.0};
  make();
  EXPECT_FALSE(add(fix_message(1.0)));
  EXPECT_EQ(lines_.back(),
            "fix: message refused, it is 111 km from the datum, allowed: 100 km; see fusion/datum");
  EXPECT_EQ(refusals(), (Counts{{"fix: far from the datum", 1}}));
}

TEST_F(Bridge, SaysWhatIsWrongWithAFix) {
  EXPECT_FALSE(add(fix_message(1.0)));
  EXPECT_EQ(lines_.back(), "fix: message refused, no tf from 'gps_link' to 'base_link'");
  transforms_["gps_link"] = Eigen::Isometry3d::Identity();
  auto none = fix_message(2.0);
  none.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
  EXPECT_FALSE(add(none));
  EXPECT_EQ(lines_.back(), "fix: message refused, its status is -1: the receiver has no fix");
  auto unsure = fix_message(2.0);
  unsure.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
  EXPECT_FALSE(add(unsure));
  EXPECT_EQ(lines_.back(),
            "fix: message refused, its covariance is unknown; set fusion/fix_sigma to use such fixes");
  auto nowhere = fix_message(2.0);
  nowhere.latitude = kNan;
  EXPECT_FALSE(add(nowhere));
  EXPECT_EQ(
      refusals(),
      (Counts{
          {"fix: no transform", 1}, {"fix: no fix", 1}, {"fix: no covariance", 1}, {"fix: not finite", 1}}));
}

TEST_F(Bridge, RangesHaveTheirReceiversPlace) {
  transforms_["range_link"] = Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.4));
  BeaconRanges message;
  message.header.stamp = ros::Time(1.0);
  message.header.frame_id = "range_link";
  message.ranges.resize(1);
  message.ranges[0].beacon = 7;
  message.ranges[0].range = 5.0;
  message.ranges[0].variance = 0.01;
  EXPECT_TRUE(bridge_->add_ranges(message, ros::Time()));
  ASSERT_EQ(frames_out_[0].ranges.size(), 1U);
  EXPECT_EQ(frames_out_[0].ranges[0].beacon, 7);
  EXPECT_EQ(frames_out_[0].ranges[0].receiver_in_base.z(), 0.4);
}

TEST_F(Bridge, AnImuOnItsSideGivesTheYawRate) {
  Eigen::Isometry3d base_from_imu = Eigen::Isometry3d::Identity();
  base_from_imu.linear() = (Eigen::AngleAxisd(radians(-90.0), Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(radians(90.0), Eigen::Vector3d::UnitX()))
                               .toRotationMatrix();
  base_from_imu.translation() = Eigen::Vector3d(0.0, -0.3, 0.52);
  transforms_["imu_link"] = base_from_imu;
  sensor_msgs::Imu message = imu_message(1.0);
  message.header.frame_id = "imu_link";
  message.angular_velocity.y = 0.7;  // the IMU's y axis points up
  message.angular_velocity.z = 0.0;
  EXPECT_TRUE(add(message));
  EXPECT_TRUE(MatrixNear(*frames_out_[0].gyro_rate, Eigen::Vector3d(0.0, 0.0, 0.7), 1e-12));
}

TEST_F(Bridge, DetectionsAreSeenFromTheBase) {
  transforms_["camera"] = Eigen::Isometry3d(Eigen::Translation3d(0.2, 0.1, 0.5));
  LandmarkDetectionArray message = landmarks_message(1.0);
  message.header.frame_id = "/camera";  // an old slash is forgiven
  odometry(1.0);
  EXPECT_TRUE(add(message));
  odometry(1.1);
  ASSERT_EQ(looks(), 1);
  for (const SensorFrame& frame : frames_out_) {
    if (!frame.detections) continue;
    EXPECT_TRUE(MatrixNear(frame.detections->at(0).position_in_base, Eigen::Vector3d(1.2, 0.1, 0.5), 1e-12));
  }
}

TEST_F(Bridge, RefusesOdometryOfOtherFrames) {
  nav_msgs::Odometry message = odometry_message(1.0);
  message.child_frame_id = "other_base";
  EXPECT_FALSE(add(message));
  message = odometry_message(1.0);
  message.header.frame_id = "world";
  EXPECT_FALSE(add(message));
  EXPECT_EQ(refusals(), (Counts{{"odometry: frame", 2}}));
  EXPECT_TRUE(frames_out_.empty());
  EXPECT_EQ(
      lines_[0],
      "odometry: message refused, frames 'odom' -> 'other_base', expected frames/odom 'odom' -> frames/base "
      "'base_link'");
}

TEST_F(Bridge, RefusesWhatIsNotFinite) {
  nav_msgs::Odometry odometry = odometry_message(1.0);
  odometry.twist.twist.linear.x = kNan;
  EXPECT_FALSE(add(odometry));
  odometry = odometry_message(1.0);
  odometry.twist.twist.angular.z = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(add(odometry));
  odometry = odometry_message(1.0);
  odometry.pose.pose.position.x = kNan;
  EXPECT_FALSE(add(odometry));
  odometry = odometry_message(1.0);
  odometry.pose.pose.orientation.w = 0.0;
  EXPECT_FALSE(add(odometry));
  odometry = odometry_message(1.0);
  odometry.pose.pose.position.x = 1e300;  // tf could not carry map -> odom
  EXPECT_FALSE(add(odometry));
  sensor_msgs::Imu imu = imu_message(1.0);
  imu.angular_velocity.x = kNan;
  EXPECT_FALSE(add(imu));
  EXPECT_EQ(refusals(), (Counts{{"odometry: not finite", 5}, {"imu: not finite", 1}}));
  EXPECT_TRUE(frames_out_.empty());
}

TEST_F(Bridge, RefusesAnImuThatHasNoGyro) {
  sensor_msgs::Imu message = imu_message(1.0);
  message.angular_velocity_covariance[0] = -1.0;
  EXPECT_FALSE(add(message));
  EXPECT_EQ(refusals(), (Counts{{"imu: no rates", 1}}));
}

TEST_F(Bridge, RefusesWhatTfCannotPlace) {
  sensor_msgs::Imu imu = imu_message(1.0);
  imu.header.frame_id = "nowhere";
  EXPECT_FALSE(add(imu));
  LandmarkDetectionArray message = landmarks_message(1.0);
  message.header.frame_id = "nowhere";
  odometry(1.0);
  add(message);
  odometry(1.1);
  EXPECT_EQ(refusals(), (Counts{{"imu: no transform", 1}, {"landmarks: no transform", 1}}));
  EXPECT_EQ(looks(), 0);
}

TEST_F(Bridge, DoesNotAskTfForFramesThatCannotBe) {
  double time = 1.0;
  for (const char* frame : {"", "/", "//camera"}) {
    sensor_msgs::Imu imu = imu_message(time += 1.0);
    imu.header.frame_id = frame;
    EXPECT_FALSE(add(imu)) << frame;
  }
  EXPECT_EQ(refusals(), (Counts{{"imu: no transform", 3}}));
}

TEST_F(Bridge, RefusesDetectionsWithoutAFrame) {
  LandmarkDetectionArray message = landmarks_message(1.0);
  message.header.frame_id = "";
  EXPECT_FALSE(add(message));
  EXPECT_EQ(refusals(), (Counts{{"landmarks: frame", 1}}));
}

TEST_F(Bridge, WhatMessagesSayIsShownOnOneShortLine) {
  nav_msgs::Odometry message = odometry_message(1.0);
  message.header.frame_id = "a\nb" + std::string(100000, 'x');
  EXPECT_FALSE(add(message));
  EXPECT_EQ(lines_.front().find("odometry: message refused, frames 'a?bxx"), 0U);
  EXPECT_LT(lines_.front().size(), 400U);
}

TEST_F(Bridge, RefusesMoreThanAnyDetectorSends) {
  LandmarkDetectionArray crowd = landmarks_message(1.0);
  crowd.detections.resize(10001);
  LandmarkDetectionArray wordy = landmarks_message(1.0);
  wordy.detections[0].label = std::string(1001, 'x');
  LandmarkDetectionArray detailed = landmarks_message(1.0);
  detailed.detections[0].descriptor.resize(4097);
  for (const LandmarkDetectionArray& message : {crowd, wordy, detailed}) EXPECT_FALSE(add(message));
  EXPECT_EQ(refusals(), Counts({{"landmarks: too large", 3}}));
  EXPECT_EQ(lines_.front(),
            "landmarks: message refused, detections: 10001 given, allowed: no more than 10000");
}

TEST_F(Bridge, APoseFromAPersonNeedsTheMapsFrame) {
  geometry_msgs::PoseWithCovarianceStamped message = position_message(0.0);
  for (const std::string frame : {"odom", "", "world", "//map"}) {
    message.header.frame_id = frame;
    EXPECT_FALSE(bridge_->initial_pose(message)) << frame;
  }
  EXPECT_EQ(refusals(), Counts({{"initialpose: frame", 4}}));
  for (const std::string frame : {"map", "/map"}) {  // older nodes write a slash
    message.header.frame_id = frame;
    message.pose.covariance.assign(0.0);
    const auto pose = bridge_->initial_pose(message);
    ASSERT_TRUE(pose) << frame;
    EXPECT_EQ(pose->map_from_base.translation().x(), 7.0);
    EXPECT_GT(pose->covariance.diagonal().minCoeff(), 0.05) << "unknown is never zero";
  }
}

TEST_F(Bridge, RefusesStampsThatCannotBe) {
  EXPECT_FALSE(odometry(0.0));
  EXPECT_TRUE(odometry(10.0, 10.0));
  EXPECT_FALSE(odometry(10.0, 10.0));
  EXPECT_FALSE(odometry(9.5, 10.0));
  EXPECT_FALSE(odometry(11.5, 10.0));
  EXPECT_TRUE(odometry(10.9, 10.0)) << "a little ahead of the clock is allowed";
  EXPECT_EQ(refusals(), (Counts{{"odometry: no stamp", 1},
                                {"odometry: repeated", 1},
                                {"odometry: old", 1},
                                {"odometry: future", 1}}));
  EXPECT_EQ(frames_out_.size(), 2U);
}

TEST_F(Bridge, WithoutAClockNothingIsInTheFuture) { EXPECT_TRUE(odometry(1e6)); }

TEST_F(Bridge, OneBadOldStampIsNoJumpOfTime) {
  EXPECT_TRUE(odometry(100.0));
  EXPECT_FALSE(odometry(5.0));
  EXPECT_TRUE(odometry(100.1));
  EXPECT_FALSE(odometry(5.0));
  EXPECT_FALSE(odometry(5.1));
  EXPECT_TRUE(odometry(100.2));
  EXPECT_EQ(jumps_, 0);
  EXPECT_EQ(refusals(), (Counts{{"odometry: old", 3}}));
}

TEST_F(Bridge, OneStampFarAheadDoesNotMakeTheRestLookOld) {
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(odometry(10.0 + 0.1 * i));
  EXPECT_FALSE(odometry(111.0));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(odometry(11.0 + 0.1 * i));
  EXPECT_EQ(bridge_->refusals(), (Counts{{"odometry: future", 1}}));
  EXPECT_EQ(jumps_, 0);
}

TEST_F(Bridge, OdometryThatWasSilentGoesOnAtItsSecondMessage) {
  EXPECT_TRUE(odometry(10.0));
  EXPECT_FALSE(odometry(60.0));
  EXPECT_TRUE(odometry(60.1));
  EXPECT_TRUE(odometry(60.2));
}

TEST_F(Bridge, TheFirstDetectionsAfterABlindDriveAreTaken) {
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(odometry(10.0 + 0.1 * i));
  EXPECT_TRUE(landmarks(10.0));
  EXPECT_TRUE(landmarks(59.9));
}

TEST_F(Bridge, OdometryThatStaysOldIsAJumpOfTime) {
  odometry(100.0);
  landmarks(100.0);
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(odometry(5.0 + 0.1 * i)) << i;
  EXPECT_FALSE(landmarks(5.8));
  EXPECT_TRUE(odometry(5.9));
  EXPECT_EQ(jumps_, 1);
  EXPECT_TRUE(landmarks(5.9)) << "the other inputs have forgotten their stamps too";
  EXPECT_TRUE(odometry(6.0));
  EXPECT_EQ(jumps_, 1);
}

TEST_F(Bridge, OldMessagesOfOtherInputsAreNoJumpOfTime) {
  odometry(100.0);
  imu(100.0);
  landmarks(100.0);
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(imu(90.0 + 0.01 * i));
    EXPECT_FALSE(landmarks(90.0 + 0.01 * i));
    EXPECT_TRUE(odometry(100.1 + 0.1 * i));
  }
  EXPECT_EQ(jumps_, 0);
}

TEST_F(Bridge, StampsAtTheEndOfTimeAreRefused) { EXPECT_FALSE(odometry(4294967295.0)); }

TEST_F(Bridge, AStampThatTheDelayPutsBeforeZeroIsRefused) {
  sync_.odometry_delay = -2.0;
  make();
  EXPECT_FALSE(odometry(1.0));
  EXPECT_TRUE(odometry(3.0));
}

TEST_F(Bridge, SlightlyOldStampsAreNeverAJump) {
  odometry(100.0);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(odometry(99.5));
  EXPECT_EQ(jumps_, 0);
}

TEST_F(Bridge, DetectionsNeedOdometryNearThem) {
  for (int i = 0; i < 10; ++i) {
    odometry(1.0 + 0.1 * i);
    landmarks(1.03 + 0.1 * i);
  }
  odometry(2.0);
  EXPECT_EQ(looks(), 10);
  EXPECT_TRUE(refusals().empty());
}

TEST_F(Bridge, DetectionsFarFromAnyOdometryAreCounted) {
  odometry(1.0);
  landmarks(1.5);  // half a second from the next odometry on both sides
  odometry(2.0);
  landmarks(2.0);
  odometry(3.0);
  landmarks(3.0);
  odometry(4.0);
  EXPECT_EQ(looks(), 2);
  EXPECT_EQ(refusals(), (Counts{{"landmarks: unsynchronized", 1}}));
}

TEST_F(Bridge, WithAnImuThreeMustAgree) {
  imu(0.91);  // from now on an IMU is expected
  for (int i = 0; i < 10; ++i) {
    odometry(1.0 + 0.1 * i);
    imu(1.01 + 0.1 * i);
    landmarks(1.02 + 0.1 * i);
  }
  odometry(2.0);
  imu(2.01);
  landmarks(2.02);  // only now is it sure that nothing fits the tenth better
  EXPECT_EQ(looks(), 10);
  EXPECT_TRUE(refusals().empty());
}

TEST_F(Bridge, WithAnImuDetectionsFarFromItAreCounted) {
  imu(0.91);
  for (int i = 0; i < 10; ++i) {
    odometry(1.0 + 0.1 * i);
    if (i != 4) imu(1.01 + 0.1 * i);
    landmarks(1.02 + 0.1 * i);
  }
  EXPECT_EQ(refusals(), (Counts{{"landmarks: unsynchronized", 1}}));
}

TEST_F(Bridge, AnImuThatGoesSilentDoesNotBlindTheRobot) {
  for (int i = 0; i < 10; ++i) {
    odometry(1.0 + 0.1 * i);
    imu(1.01 + 0.1 * i);
    landmarks(1.02 + 0.1 * i);
  }
  const int before = looks();
  for (int i = 0; i < 40; ++i) {
    odometry(2.0 + 0.1 * i);
    landmarks(2.02 + 0.1 * i);
  }
  EXPECT_GE(looks(), before + 25) << "a second without IMU is enough";
  EXPECT_EQ(refusals()["imu: silent"], 1U);
}

TEST_F(Bridge, AnImuThatComesLateIsUsedFromThenOn) {
  for (int i = 0; i < 5; ++i) {
    odometry(1.0 + 0.1 * i);
    landmarks(1.02 + 0.1 * i);
  }
  for (int i = 0; i < 10; ++i) {
    odometry(1.5 + 0.1 * i);
    imu(1.51 + 0.1 * i);
    landmarks(1.52 + 0.1 * i);
  }
  odometry(2.5);
  imu(2.51);
  EXPECT_GE(looks(), 13);
}

TEST_F(Bridge, DetectionsThatWaitWhenTheFirstImuMessageComesAreUsedOnce) {
  landmarks(1.0);
  imu(1.0);
  odometry(1.0);
  imu(1.1);
  odometry(1.1);
  imu(1.2);
  odometry(1.2);
  EXPECT_EQ(looks(), 1);

  make();
  frames_out_.clear();
  landmarks(1.0);
  odometry(1.0);
  EXPECT_EQ(looks(), 1) << "no IMU so far: a pair";
  for (const double time : {1.0, 1.1, 1.2}) {
    imu(time);
    odometry(time + 0.1);
  }
  EXPECT_EQ(looks(), 1);
}

TEST_F(Bridge, OdometryThatIsStampedEarlyIsDatedLater) {
  sync_.odometry_delay = 0.25;
  make();
  odometry(1.0);
  EXPECT_EQ(frames_out_[0].stamp, 1250000000);
  landmarks(1.25);  // agrees with the odometry's true time, not with its stamp
  odometry(1.1);
  odometry(1.2);
  EXPECT_EQ(looks(), 1);
}

TEST_F(Bridge, AnEmptyArrayIsALook) {
  LandmarkDetectionArray message = landmarks_message(1.0);
  message.detections.clear();
  odometry(1.0);
  EXPECT_TRUE(add(message));
  odometry(1.1);
  ASSERT_EQ(looks(), 1);
}

TEST_F(Bridge, ResetForgetsStampsAndKeepsTheCounters) {
  odometry(100.0);
  odometry(100.0);
  bridge_->reset();
  EXPECT_TRUE(odometry(5.0));
  EXPECT_EQ(refusals(), (Counts{{"odometry: repeated", 1}}));
  EXPECT_EQ(bridge_->accepted(), (Counts{{"odometry", 2}}));
}

}  // namespace
}  // namespace kinect_ekf_slam
