#include "kinect_ekf_slam/ros/conversions.h"

#include <gtest/gtest.h>

#include <limits>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

LandmarkDetection detection(double x, double y, double z) {
  LandmarkDetection message;
  message.id = -1;
  message.position.x = x;
  message.position.y = y;
  message.position.z = z;
  return message;
}

Eigen::Isometry3d transform(const Eigen::Vector3d& translation, double yaw) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.translation() = translation;
  transform.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return transform;
}

TEST(Conversions, TimeGoesThereAndBackExactly) {
  for (const TimeNs stamp : {TimeNs{0}, TimeNs{1}, TimeNs{999999999}, TimeNs{1700000000123456789}}) {
    EXPECT_EQ(to_time(to_ros(stamp)), stamp);
  }
  EXPECT_THROW(to_ros(-1), std::runtime_error);
}

TEST(Conversions, PosesGoThereAndBack) {
  Eigen::Isometry3d pose = transform({1.0, -2.0, 0.3}, 2.5);
  pose.linear() = pose.linear() * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized());
  EXPECT_TRUE(MatrixNear(to_eigen(to_pose(pose)).matrix(), pose.matrix(), 1e-12));
  EXPECT_TRUE(MatrixNear(to_eigen(to_transform(pose)).matrix(), pose.matrix(), 1e-12));
}

TEST(Conversions, AQuaternionNeedNotBeNormalised) {
  geometry_msgs::Pose message;
  message.orientation.z = 5.0;
  message.orientation.w = 5.0;
  EXPECT_TRUE(
      MatrixNear(to_eigen(message).matrix(), transform(Eigen::Vector3d::Zero(), 0.5 * kPi).matrix(), 1e-12));
}

TEST(Conversions, KnowWhatIsNoPose) {
  geometry_msgs::Pose message;
  EXPECT_FALSE(is_pose(message));  // its quaternion is zero
  message.orientation.w = 1.0;
  EXPECT_TRUE(is_pose(message));
  for (const double huge :
       {1e200, 1.7e308, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    geometry_msgs::Pose nowhere = message;
    nowhere.position.z = huge;
    EXPECT_FALSE(is_pose(nowhere)) << huge;
    nowhere = message;
    nowhere.orientation.x = huge;
    EXPECT_FALSE(is_pose(nowhere)) << huge;
  }
}

TEST(Conversions, KnowOpticalFramesByTheirNames) {
  EXPECT_TRUE(is_optical("camera_rgb_optical_frame"));
  EXPECT_TRUE(is_optical("kinect_optical"));
  EXPECT_FALSE(is_optical("camera_link"));
  EXPECT_FALSE(is_optical("optical_table"));
  EXPECT_FALSE(is_optical(""));
}

/// A camera 0.3 m ahead that looks to the left: its optical frame, and a frame with body axes at the same
/// place.
TEST(ToDetection, OpticalAndBodyFramesSayTheSame) {
  const Eigen::Isometry3d base_from_body = transform({0.3, 0.0, 0.2}, 0.5 * kPi);
  Eigen::Isometry3d base_from_optical = base_from_body;
  Eigen::Matrix3d body_from_optical;
  body_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  base_from_optical.linear() = base_from_body.linear() * body_from_optical;

  const Detection optical = to_detection(detection(0.5, 0.1, 2.0), base_from_optical, true);
  const Detection body = to_detection(detection(2.0, -0.5, -0.1), base_from_body, false);
  EXPECT_TRUE(MatrixNear(optical.position_in_base, Eigen::Vector3d(0.8, 2.0, 0.1), 1e-12));
  EXPECT_TRUE(MatrixNear(body.position_in_base, optical.position_in_base, 1e-12));
  EXPECT_TRUE(MatrixNear(body.position_in_optical, Eigen::Vector3d(0.5, 0.1, 2.0), 1e-12));
  EXPECT_TRUE(MatrixNear(optical.position_in_optical, Eigen::Vector3d(0.5, 0.1, 2.0), 1e-12));
  EXPECT_TRUE(MatrixNear(body.base_from_optical, optical.base_from_optical, 1e-12));
}

TEST(ToDetection, TurnsTheCovarianceIntoTheBase) {
  LandmarkDetection message = detection(2.0, 0.0, 0.0);
  message.covariance = {0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.01};
  const Detection turned = to_detection(message, transform({5.0, 5.0, 0.0}, 0.5 * kPi), false);
  Eigen::Matrix3d expected;
  expected << 0.09, -0.01, 0.0, -0.01, 0.04, 0.0, 0.0, 0.0, 0.01;
  EXPECT_TRUE(MatrixNear(turned.covariance_in_base, expected, 1e-12));
}

TEST(ToDetection, KeepsNoCovarianceAsNone) {
  EXPECT_TRUE(
      to_detection(detection(2, 0, 0), transform({0, 0, 0}, 1.0), false).covariance_in_base.isZero(0.0));
}

TEST(ToDetection, CarriesWhatTheDetectorSays) {
  LandmarkDetection message = detection(2.0, 0.0, 0.0);
  message.id = 17;
  message.label = "red";
  message.radius = 0.06F;
  message.descriptor = {1.0F, 2.0F};
  message.score = 0.5F;
  const Detection taken = to_detection(message, Eigen::Isometry3d::Identity(), false);
  EXPECT_EQ(taken.signature.source_id, 17);
  EXPECT_EQ(taken.signature.label, "red");
  EXPECT_FLOAT_EQ(static_cast<float>(taken.signature.radius), 0.06F);
  EXPECT_EQ(taken.signature.descriptor.size(), 2U);
  EXPECT_EQ(taken.score, 0.5);
}

/// One of them would spoil all comparisons with the landmark's.
TEST(ToDetection, ADescriptorWithoutNumbersIsNone) {
  LandmarkDetection message = detection(2.0, 0.0, 0.0);
  message.descriptor = {1.0F, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_TRUE(to_detection(message, Eigen::Isometry3d::Identity(), false).signature.descriptor.empty());
}

TEST(ToDetection, AnyNegativeIdentityIsNone) {
  LandmarkDetection message = detection(2.0, 0.0, 0.0);
  message.id = -7;
  EXPECT_EQ(to_detection(message, Eigen::Isometry3d::Identity(), false).signature.source_id, kNoId);
}

TEST(ToDetection, ARadiusThatIsNoneIsUnknown) {
  LandmarkDetection message = detection(2.0, 0.0, 0.0);
  for (const float radius :
       {-1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    message.radius = radius;
    EXPECT_EQ(to_detection(message, Eigen::Isometry3d::Identity(), false).signature.radius, 0.0) << radius;
  }
}

TEST(ToDetection, LetsNumbersThatAreNoneThroughToBeCounted) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LandmarkDetection message = detection(nan, 0.0, 1.0);
  EXPECT_FALSE(to_detection(message, Eigen::Isometry3d::Identity(), false).position_in_base.allFinite());
  message = detection(1.0, 0.0, 1.0);
  message.covariance[4] = nan;
  EXPECT_FALSE(to_detection(message, Eigen::Isometry3d::Identity(), false).covariance_in_base.allFinite())
      << "a broken covariance is not the same as none";
}

TEST(ToMessage, APoseFillsTheRowsOfRep103) {
  Pose3d pose;
  for (int i = 0; i < 36; ++i) pose.covariance(i / 6, i % 6) = i;
  const auto message = to_pose_with_covariance(pose);
  for (int i = 0; i < 36; ++i) EXPECT_EQ(message.covariance[i], i);
}

TEST(ToMessage, AMapCarriesAllOfItsLandmarks) {
  Landmark3d landmark;
  landmark.id = 3;
  landmark.source_id = 9;
  landmark.label = "blue";
  landmark.radius = 0.05;
  landmark.observations = 12;
  landmark.position_in_map = {1.0, 2.0, 0.0};
  landmark.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  const LandmarkMap message = to_message({landmark}, "map", 5000000000);
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.header.stamp, ros::Time(5.0));
  ASSERT_EQ(message.landmarks.size(), 1U);
  EXPECT_EQ(message.landmarks[0].id, 3);
  EXPECT_EQ(message.landmarks[0].source_id, 9);
  EXPECT_EQ(message.landmarks[0].label, "blue");
  EXPECT_EQ(message.landmarks[0].observations, 12U);
  EXPECT_EQ(message.landmarks[0].covariance[5], 6.0);
}

TEST(ToMessage, AMapSaysWhichLandmarksAreProvisional) {
  std::vector<Landmark3d> map(2);
  map[1].confirmed = false;
  const LandmarkMap message = to_message(map, "map", 0);
  ASSERT_EQ(message.landmarks.size(), 2U) << "provisional ones are told too";
  EXPECT_EQ(message.landmarks[0].status, Landmark::CONFIRMED);
  EXPECT_EQ(message.landmarks[1].status, Landmark::PROVISIONAL);
}

TEST(ToMessage, AssociationsNameTheVerdict) {
  DetectionOutcome outcome;
  outcome.source_id = 4;
  outcome.verdict = Verdict::kOutsideGate;
  outcome.landmark_id = 2;
  outcome.nis = 12.5;
  const AssociationArray message = to_message({DetectionOutcome(), outcome}, "map", 0);
  ASSERT_EQ(message.associations.size(), 2U);
  EXPECT_EQ(message.associations[1].detection, 1U);
  EXPECT_EQ(message.associations[1].verdict, "outside_gate");
  EXPECT_EQ(message.associations[1].landmark, 2);
  EXPECT_EQ(message.associations[1].nis, 12.5);
}

}  // namespace
}  // namespace kinect_ekf_slam
