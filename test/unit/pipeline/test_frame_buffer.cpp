#include "kinect_ekf_slam/pipeline/frame_buffer.h"

#include <gtest/gtest.h>

namespace kinect_ekf_slam {
namespace {

SensorFrame odometry(double time, double mark = 0.0) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.odometry.emplace();
  frame.odometry->linear.x() = mark;
  return frame;
}

SensorFrame detections(double time) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.detections.emplace();
  return frame;
}

SensorFrame position(double time) {
  SensorFrame frame;
  frame.stamp = to_nanoseconds(time);
  frame.position.emplace();
  return frame;
}

using Times = std::vector<TimeNs>;  // ms

Times times(const std::vector<SensorFrame>& frames) {
  Times times;
  for (const SensorFrame& frame : frames) times.push_back(frame.stamp / 1000000);
  return times;
}

TEST(FrameBuffer, OdometryWaitsForDetections) {
  FrameBuffer buffer(1.0, 100);
  EXPECT_TRUE(buffer.add(odometry(5.0)).empty());
  EXPECT_TRUE(buffer.add(odometry(5.5)).empty());
  EXPECT_TRUE(buffer.add(odometry(5.9)).empty());
  EXPECT_EQ(buffer.waiting().size(), 3U);
}

TEST(FrameBuffer, OdometryWaitsNoLongerThanTheDelay) {
  FrameBuffer buffer(1.0, 100);
  buffer.add(odometry(5.0));
  buffer.add(odometry(5.5));
  EXPECT_EQ(times(buffer.add(odometry(6.0))), Times({5000}));
  EXPECT_EQ(times(buffer.add(odometry(7.0))), Times({5500, 6000}));
}

TEST(FrameBuffer, DetectionsReleaseWhatCameBeforeThem) {
  FrameBuffer buffer(1.0, 100);
  buffer.add(odometry(5.0));
  buffer.add(odometry(5.1));
  buffer.add(odometry(5.2));
  EXPECT_EQ(times(buffer.add(detections(5.1))), Times({5000, 5100, 5100}));
  EXPECT_EQ(buffer.waiting().size(), 1U);
}

TEST(FrameBuffer, PutsLateOdometryInItsPlace) {
  FrameBuffer buffer(1.0, 100);
  buffer.add(odometry(5.0));
  buffer.add(odometry(5.2));
  buffer.add(odometry(5.1));
  EXPECT_EQ(times(buffer.flush()), Times({5000, 5100, 5200}));
}

TEST(FrameBuffer, EqualStampsKeepTheOrderOfArrival) {
  FrameBuffer buffer(1.0, 100);
  for (int i = 0; i < 4; ++i) buffer.add(odometry(5.0, i));
  const auto due = buffer.add(detections(5.0));
  ASSERT_EQ(due.size(), 5U);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(due[i].odometry->linear.x(), i);
  EXPECT_TRUE(due[4].detections);
}

TEST(FrameBuffer, HoldsNoMoreThanItMay) {
  FrameBuffer buffer(1e6, 3);
  for (int i = 1; i <= 3; ++i) EXPECT_TRUE(buffer.add(odometry(i)).empty());
  EXPECT_EQ(times(buffer.add(odometry(4.0))), Times({1000}));
  EXPECT_EQ(buffer.waiting().size(), 3U);
}

TEST(FrameBuffer, WithoutDelayLetsAllThrough) {
  FrameBuffer buffer(0.0, 100);
  EXPECT_EQ(times(buffer.add(odometry(5.0))), Times({5000}));
  EXPECT_EQ(times(buffer.add(detections(5.05))), Times({5050}));
}

/// Detections are there at once, positions half a second later: each is used at its own time.
TEST(FrameBuffer, AllWaitsForPositionsOnceThereHaveBeenAny) {
  FrameBuffer buffer(1.0, 100, 0.5);
  EXPECT_EQ(times(buffer.add(detections(5.0))), Times({5000}));
  buffer.add(position(5.1));
  EXPECT_EQ(times(buffer.add(detections(5.4))), Times({5100}));
  EXPECT_EQ(times(buffer.add(position(5.2))), Times({5200}));
  EXPECT_EQ(times(buffer.add(position(5.5))), Times({5400}));
}

TEST(FrameBuffer, NothingWaitsLongerForPositionsThanTheirDelay) {
  FrameBuffer buffer(1.0, 100, 0.5);
  buffer.add(position(5.0));
  buffer.flush();
  EXPECT_TRUE(buffer.add(detections(5.6)).empty());
  EXPECT_EQ(times(buffer.add(detections(6.2))), Times({5600}));
}

TEST(FrameBuffer, FlushEmptiesIt) {
  FrameBuffer buffer(1.0, 100);
  EXPECT_TRUE(buffer.flush().empty());
  buffer.add(odometry(5.0));
  EXPECT_EQ(buffer.flush().size(), 1U);
  EXPECT_TRUE(buffer.waiting().empty());
}

}  // namespace
}  // namespace kinect_ekf_slam
