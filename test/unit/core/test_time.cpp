#include "kinect_ekf_slam/core/time.h"

#include <gtest/gtest.h>

namespace kinect_ekf_slam {
namespace {

TEST(Time, RoundsSecondsToTheNearestNanosecond) {
  EXPECT_EQ(to_nanoseconds(0.1), 100000000);
  EXPECT_EQ(to_nanoseconds(-0.07), -70000000);
  EXPECT_EQ(to_nanoseconds(1.4e-9), 1);
  EXPECT_EQ(to_nanoseconds(1.6e-9), 2);
}

TEST(Time, ComesBackFromSeconds) {
  for (const TimeNs duration :
       {TimeNs{0}, TimeNs{1}, TimeNs{-1}, TimeNs{33333333}, TimeNs{86400} * 1000000000}) {
    EXPECT_EQ(to_nanoseconds(to_seconds(duration)), duration);
  }
}

TEST(Time, TellsNeighbouringNanosecondsOfTodayApart) {
  const TimeNs today = 1700000000123456789;  // seconds in a double would be 200 ns off
  EXPECT_DOUBLE_EQ(to_seconds(today + 1 - today), 1e-9);
}

}  // namespace
}  // namespace kinect_ekf_slam
