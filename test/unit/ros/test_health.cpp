#include "kinect_ekf_slam/ros/health.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <string>

namespace kinect_ekf_slam {
namespace {

/// Health of a node that started at second 100, and what it reports.
class InputHealth : public ::testing::Test {
 protected:
  void SetUp() override { ros::Time::init(); }  // message_filters asks for a clock

  diagnostic_updater::DiagnosticStatusWrapper report(double now) {
    const SensorBridge bridge({}, {}, {}, {});
    diagnostic_updater::DiagnosticStatusWrapper status;
    health_.report_inputs(bridge, ros::Time(now), status);
    return status;
  }
  static std::string value(const diagnostic_updater::DiagnosticStatusWrapper& status,
                           const std::string& key) {
    for (const auto& item : status.values)
      if (item.key == key) return item.value;
    return "no " + key;
  }

  Health health_{{"/odom", "none", "/landmarks", {}, 1.0, 2}, ros::Time(100.0)};
};

TEST_F(InputHealth, WarnsWhileMessagesWaitLongerThanHalfASecond) {
  health_.note_input("odometry", ros::Time(101.0), ros::Time(100.9));
  health_.note_input("landmarks", ros::Time(101.0), ros::Time(100.4));
  health_.note_input("landmarks", ros::Time(101.1), ros::Time(101.1));
  const auto late = report(101.2);
  EXPECT_EQ(late.level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(late.message, "messages on /landmarks wait: more come than the node can use");
  EXPECT_EQ(value(late, "landmarks longest wait (s)"), "0.600");
  EXPECT_EQ(value(late, "odometry longest wait (s)"), "0.100");

  health_.note_input("odometry", ros::Time(102.0), ros::Time(101.5));
  const auto in_time = report(102.2);
  EXPECT_EQ(in_time.level, diagnostic_msgs::DiagnosticStatus::OK) << in_time.message;
  EXPECT_EQ(value(in_time, "landmarks longest wait (s)"), "0.000") << "the last report told of it";
}

TEST_F(InputHealth, BearsAClockThatJumpsAsFarAsStampsGo) {
  health_.note_input("odometry", ros::Time(4294967295.0), ros::Time(1.0));
  health_.note_input("odometry", ros::Time(1.0), ros::Time(4294967295.0));
  EXPECT_EQ(value(report(2.0), "odometry longest wait (s)"), "4294967294.000");
}

}  // namespace
}  // namespace kinect_ekf_slam
