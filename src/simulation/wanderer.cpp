#include "kinect_ekf_slam/simulation/wanderer.h"

#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kSpeed = 0.2;         // m/s
constexpr double kTurnRate = 0.6;      // rad/s
constexpr double kStandingTime = 2.0;  // s; the gyro's bias is learnt

}  // namespace

BodyVelocity Wanderer::command(TimeNs now, const BodyVelocity& odometry) {
  constexpr double kStartTime = 1.0;  // s; a robot that does not move by then is stopped by something
  constexpr double kStopped = 0.01;   // m/s
  BodyVelocity velocity;
  if (to_seconds(now) < kStandingTime) return velocity;
  if (!started_) {
    started_ = true;
    turn(now, 2.0 * kPi);
  }
  const bool blocked =
      now > turn_end_ + to_nanoseconds(kStartTime) && std::abs(odometry.linear.x()) < kStopped;
  if (now > turn_end_ && (blocked || now > straight_end_)) {
    const double angle = random_.uniform(radians(45.0), radians(180.0));
    turn(now, random_.chance(0.5) ? angle : -angle);
  }
  if (now <= turn_end_) {
    velocity.angular.z() = turn_rate_;
  } else {
    velocity.linear.x() = kSpeed;
  }
  return velocity;
}

void Wanderer::turn(TimeNs now, double angle) {
  turn_rate_ = std::copysign(kTurnRate, angle);
  turn_end_ = now + to_nanoseconds(std::abs(angle) / kTurnRate);
  straight_end_ = turn_end_ + to_nanoseconds(random_.uniform(4.0, 12.0));
}

}  // namespace kinect_ekf_slam
