#include "kinect_ekf_slam/models/input_conditioner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/body_velocity.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::velocity;

Eigen::Vector3d yaw(double rate) { return {0.0, 0.0, rate}; }

constexpr TimeNs kSecond = 1000000000;

InputOptions without_bias() {
  InputOptions options;
  options.estimate_gyro_bias = false;
  return options;
}

struct Saturation {
  double forward, turn, expected_forward, expected_turn;
};

TEST(Saturation, ClampsAndKeepsTheSign) {
  const Saturation cases[] = {{0.1, 0.5, 0.1, 0.5},       {0.22, 1.1, 0.22, 1.1},    {0.23, 1.2, 0.22, 1.1},
                              {-0.23, -1.2, -0.22, -1.1}, {50.0, -70.0, 0.22, -1.1}, {-0.1, 9.0, -0.1, 1.1},
                              {0.0, 0.0, 0.0, 0.0}};
  for (const Saturation& c : cases) {
    InputConditioner conditioner(without_bias());
    conditioner.add_odometry(1, velocity(c.forward, c.turn));
    EXPECT_DOUBLE_EQ(conditioner.velocity(1).linear.x(), c.expected_forward);
    EXPECT_DOUBLE_EQ(conditioner.velocity(1).angular.z(), c.expected_turn);
  }
}

TEST(Saturation, ShortensASidewaysVelocityWithoutTurningIt) {
  InputConditioner conditioner(without_bias());
  BodyVelocity fast;
  fast.linear = {3.0, 4.0, 0.0};
  conditioner.add_odometry(1, fast);
  EXPECT_TRUE(MatrixNear(conditioner.velocity(1).linear, Eigen::Vector3d(0.132, 0.176, 0.0), 1e-12));
}

TEST(Saturation, ClampsWhatOverflows) {
  InputOptions options = without_bias();
  for (const double scale : {1.0, 2.0}) {
    options.linear_scale = options.angular_scale = scale;
    for (const double huge : {1e200, -1e300, 1.7e308}) {
      InputConditioner conditioner(options);
      conditioner.add_odometry(1, velocity(huge, huge));
      EXPECT_DOUBLE_EQ(conditioner.velocity(1).linear.x(), std::copysign(0.22, huge));
      EXPECT_DOUBLE_EQ(conditioner.velocity(1).angular.z(), std::copysign(1.1, huge));
    }
  }
}

TEST(Saturation, HoldsForTheGyroToo) {
  InputOptions options = without_bias();
  options.heading_source = HeadingSource::kImu;
  InputConditioner conditioner(options);
  conditioner.add_odometry(1, velocity(0.1, 0.0));
  conditioner.add_gyro(1, yaw(-4.0));
  EXPECT_DOUBLE_EQ(conditioner.velocity(1).angular.z(), -1.1);
}

TEST(Calibration, ScalesBeforeItSaturates) {
  InputOptions options = without_bias();
  options.linear_scale = 0.5;
  options.angular_scale = 2.0;
  InputConditioner conditioner(options);
  conditioner.add_odometry(1, velocity(0.3, 0.4));
  EXPECT_DOUBLE_EQ(conditioner.velocity(1).linear.x(), 0.15);
  EXPECT_DOUBLE_EQ(conditioner.velocity(1).angular.z(), 0.8);
}

struct Heading {
  double forward, wheels, gyro;
  double report, gyrodometry;  ///< what the two modes that choose make of it
};

TEST(Heading, IsChosenAsTheReportMeansIt) {
  const double period = 0.1;
  const double threshold = radians(0.03) / period;  // 0.00524 rad/s
  const double below = 0.9 * threshold;
  const double above = 1.1 * threshold;
  const Heading cases[] = {
      // forward, wheels,  gyro,           report,          gyrodometry
      {0.2, 0.3, 0.3 + above, 0.3 + above, 0.3 + above},  // they differ: the gyro
      {0.2, 0.3, 0.3 - above, 0.3 - above, 0.3 - above},
      {0.2, 0.3, 0.3 + below, 0.3 + below, 0.3},  // they agree, the robot drives
      {0.2, 0.3, 0.3 - below, 0.3 - below, 0.3},
      {0.0, 0.3, 0.3 + below, 0.3, 0.3},  // they agree, it turns on the spot
      {0.0, 0.0, below, 0.0, 0.0},        // at rest a small bias does not turn it
      {0.0, 0.0, above, above, above},    // at rest it is pushed
      {-0.2, 0.0, below, below, 0.0},     // it drives backwards
  };
  for (const Heading& c : cases) {
    for (const auto& [source, expected] :
         {std::pair(HeadingSource::kGyrodometryReport, c.report),
          std::pair(HeadingSource::kGyrodometry, c.gyrodometry),
          std::pair(HeadingSource::kOdometry, c.wheels), std::pair(HeadingSource::kImu, c.gyro)}) {
      InputOptions options = without_bias();
      options.heading_source = source;
      InputConditioner conditioner(options);
      conditioner.add_odometry(kSecond, velocity(c.forward, c.wheels));
      const TimeNs next = kSecond + to_nanoseconds(period);
      conditioner.add_odometry(next, velocity(c.forward, c.wheels));
      conditioner.add_gyro(next, yaw(c.gyro));
      EXPECT_DOUBLE_EQ(conditioner.velocity(next).angular.z(), expected)
          << "source " << static_cast<int>(source) << ", v " << c.forward << ", wheels " << c.wheels
          << ", gyro " << c.gyro;
    }
  }
}

TEST(Heading, ThresholdIsAnAngleAStep) {
  InputOptions options = without_bias();
  options.heading_source = HeadingSource::kGyrodometry;
  const double difference = radians(0.03) / 0.1;  // exactly the threshold at 10 Hz
  for (const auto& [period, uses_gyro] : {std::pair(0.05, false), std::pair(0.2, true)}) {
    InputConditioner conditioner(options);
    conditioner.add_odometry(kSecond, velocity(0.1, 0.0));
    const TimeNs next = kSecond + to_nanoseconds(period);
    conditioner.add_odometry(next, velocity(0.1, 0.0));
    conditioner.add_gyro(next, yaw(difference));
    EXPECT_DOUBLE_EQ(conditioner.velocity(next).angular.z(), uses_gyro ? difference : 0.0) << period;
  }
}

TEST(Heading, IsTheOdometrysWithoutAGyro) {
  for (const auto source : {HeadingSource::kGyrodometryReport, HeadingSource::kGyrodometry,
                            HeadingSource::kOdometry, HeadingSource::kImu}) {
    InputOptions options;
    options.heading_source = source;
    InputConditioner conditioner(options);
    conditioner.add_odometry(1, velocity(0.1, 0.4));
    EXPECT_DOUBLE_EQ(conditioner.velocity(1).angular.z(), 0.4);
  }
}

TEST(Heading, DoesNotUseAGyroThatWentSilent) {
  InputOptions options = without_bias();
  options.heading_source = HeadingSource::kImu;
  options.max_gyro_age = 0.07;
  InputConditioner conditioner(options);
  conditioner.add_odometry(kSecond, velocity(0.1, 0.4));
  conditioner.add_gyro(kSecond, yaw(0.9));
  EXPECT_DOUBLE_EQ(conditioner.velocity(kSecond + to_nanoseconds(0.07)).angular.z(), 0.9);
  EXPECT_DOUBLE_EQ(conditioner.velocity(kSecond + to_nanoseconds(0.08)).angular.z(), 0.4);
}

TEST(Heading, LeavesTheVelocityOfTheOdometryAlone) {
  InputOptions options = without_bias();
  options.heading_source = HeadingSource::kImu;
  InputConditioner conditioner(options);
  BodyVelocity sideways;
  sideways.linear = {0.1, 0.05, 0.0};
  conditioner.add_odometry(1, sideways);
  conditioner.add_gyro(1, {0.0, 0.0, 0.2});
  EXPECT_TRUE(MatrixNear(conditioner.velocity(1).linear, sideways.linear, 0.0));
  EXPECT_TRUE(MatrixNear(conditioner.velocity(1).angular, yaw(0.2), 0.0));
}

/// In space the rule is the heading's for each axis: here gyro and odometry agree on the pitch alone.
TEST(Heading, IsChosenForEachAxisByItself) {
  InputOptions options = without_bias();
  options.heading_source = HeadingSource::kGyrodometry;
  InputConditioner conditioner(options);
  BodyVelocity flying;
  flying.linear.x() = 0.1;
  flying.angular = {0.3, -0.2, 0.4};
  conditioner.add_odometry(kSecond, flying);
  const TimeNs next = kSecond + kSecond / 10;
  conditioner.add_odometry(next, flying);
  conditioner.add_gyro(next, {0.31, -0.201, 0.39});
  const BodyVelocity chosen = conditioner.velocity(next);
  EXPECT_TRUE(MatrixNear(chosen.angular, Eigen::Vector3d(0.31, -0.2, 0.39), 1e-12));
  EXPECT_EQ(chosen.turned_by_gyro, (std::array<bool, 3>{true, false, true}));
}

/// 20 Hz odometry and 100 Hz gyro for `seconds`.
void run(InputConditioner* conditioner, TimeNs* now, double seconds, const BodyVelocity& odometry,
         const Eigen::Vector3d& gyro, double noise = 0.0) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0.0, noise > 0.0 ? noise : 1e-300);
  for (int i = 0; i < 100 * seconds; ++i) {
    *now += kSecond / 100;
    if (i % 5 == 0) conditioner->add_odometry(*now, odometry);
    conditioner->add_gyro(*now, gyro + Eigen::Vector3d(normal(random), normal(random), normal(random)));
  }
}

TEST(GyroBias, IsFoundWhileTheRobotStandsAndTakenOff) {
  InputOptions options;
  options.heading_source = HeadingSource::kImu;
  InputConditioner conditioner(options);
  TimeNs now = kSecond;
  conditioner.add_odometry(now, velocity(0.0, 0.0));
  run(&conditioner, &now, 5.0, velocity(0.0, 0.0), {0.01, -0.02, 0.03}, 0.01);
  EXPECT_TRUE(MatrixNear(conditioner.gyro_bias(), Eigen::Vector3d(0.01, -0.02, 0.03), 0.003));
  run(&conditioner, &now, 0.2, velocity(0.2, 0.5), yaw(0.53));
  EXPECT_NEAR(conditioner.velocity(now).angular.z(), 0.5, 0.003);
}

TEST(GyroBias, IsForgottenSlowly) {
  InputConditioner conditioner(InputOptions{});
  TimeNs now = kSecond;
  conditioner.add_odometry(now, velocity(0.0, 0.0));
  run(&conditioner, &now, 20.0, velocity(0.0, 0.0), yaw(0.02));
  run(&conditioner, &now, 10.0, velocity(0.0, 0.0), yaw(0.05));  // one time constant later
  EXPECT_NEAR(conditioner.gyro_bias().z(), 0.05 - 0.03 * std::exp(-1.0), 0.001);
}

TEST(GyroBias, IsNotLearntWhileMoving) {
  InputConditioner conditioner(InputOptions{});
  TimeNs now = kSecond;
  conditioner.add_odometry(now, velocity(0.2, 0.0));
  run(&conditioner, &now, 5.0, velocity(0.2, 0.0), yaw(0.03));
  run(&conditioner, &now, 5.0, velocity(0.0, 0.05), yaw(0.05));
  EXPECT_TRUE(MatrixNear(conditioner.gyro_bias(), Eigen::Vector3d::Zero(), 0.0));
}

TEST(GyroBias, IsNotLearntInAMomentOfRest) {
  InputConditioner conditioner(InputOptions{});
  TimeNs now = kSecond;
  for (int i = 0; i < 20; ++i) {  // a slow turn: the wheels' ticks come now and then
    run(&conditioner, &now, 0.2, velocity(0.0, i % 2 == 0 ? 0.0 : 0.1), yaw(0.05));
  }
  EXPECT_TRUE(MatrixNear(conditioner.gyro_bias(), Eigen::Vector3d::Zero(), 0.0));
}

TEST(Saturation, ARollDoesNotTakeFromTheYaw) {
  InputOptions options = without_bias();
  options.heading_source = HeadingSource::kImu;
  InputConditioner conditioner(options);
  conditioner.add_odometry(1, velocity(0.0, 1.0));
  conditioner.add_gyro(1, {0.0, 2.5, 1.0});
  EXPECT_EQ(conditioner.velocity(1).angular.z(), 1.0);
}

TEST(GyroBias, IsNotLearntWhilePushed) {
  InputConditioner conditioner(InputOptions{});
  TimeNs now = kSecond;
  conditioner.add_odometry(now, velocity(0.0, 0.0));
  run(&conditioner, &now, 5.0, velocity(0.0, 0.0), yaw(0.5));
  EXPECT_TRUE(MatrixNear(conditioner.gyro_bias(), Eigen::Vector3d::Zero(), 0.0));
}

TEST(GyroBias, IsNotLearntBeforeTheFirstOdometry) {
  InputConditioner conditioner(InputOptions{});
  for (int i = 1; i < 100; ++i) conditioner.add_gyro(i * kSecond / 100, yaw(0.03));
  EXPECT_TRUE(MatrixNear(conditioner.gyro_bias(), Eigen::Vector3d::Zero(), 0.0));
}

TEST(GyroBias, IsNotLearntWhenNotAskedFor) {
  InputConditioner conditioner(without_bias());
  TimeNs now = kSecond;
  conditioner.add_odometry(now, velocity(0.0, 0.0));
  run(&conditioner, &now, 1.0, velocity(0.0, 0.0), yaw(0.03));
  EXPECT_TRUE(MatrixNear(conditioner.gyro_bias(), Eigen::Vector3d::Zero(), 0.0));
}

TEST(OdometryGap, AVelocityHoldsNoLongerThanAllowed) {
  InputOptions options;
  options.max_odometry_gap = 0.5;
  InputConditioner conditioner(options);
  EXPECT_LE(conditioner.hold_time(kSecond), 0.0) << "before the first odometry";
  conditioner.add_odometry(kSecond, velocity(0.1, 0.0));
  EXPECT_NEAR(conditioner.hold_time(kSecond), 0.5, 1e-12);
  EXPECT_NEAR(conditioner.hold_time(kSecond + to_nanoseconds(0.3)), 0.2, 1e-12);
  EXPECT_LE(conditioner.hold_time(kSecond + to_nanoseconds(0.6)), 0.0);
}

TEST(InputConditioner, ACopyLooksAheadWithoutChangingTheOriginal) {
  InputConditioner conditioner(InputOptions{});
  conditioner.add_odometry(kSecond, velocity(0.1, 0.0));
  InputConditioner copy = conditioner;
  copy.add_odometry(2 * kSecond, velocity(0.2, 0.3));
  EXPECT_DOUBLE_EQ(conditioner.last_odometry().linear.x(), 0.1);
  EXPECT_DOUBLE_EQ(copy.last_odometry().linear.x(), 0.2);
}

}  // namespace
}  // namespace kinect_ekf_slam
