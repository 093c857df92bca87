// EKF SLAM with the core library: a robot drives circles among posts that all look alike.
#include <cmath>
#include <cstdio>
#include <vector>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/estimators/factory.h"

using namespace kinect_ekf_slam;

int main() {
  const std::vector<Eigen::Vector2d> posts_in_map{
      {2.0, -1.0}, {3.5, 2.0}, {1.0, 5.0}, {-2.5, 3.5}, {-2.0, 0.5}};
  const double range = 3.0, sensor_sigma = 0.05;        // m, how far the robot sees, and how exactly
  const Eigen::Array3d wheel_sigma(0.01, 0.002, 0.01);  // m, m, rad of each step: forward, sideways, heading
  const Se2 step = Se2::exp({0.04, 0.0, 0.021});        // what the wheels say, ten times a second

  RandomStream random(1, 0);
  Se2 truth, wheels_alone;
  const auto slam = make_estimator<Planar>({}, {}, {Se2(), 1e-6 * Eigen::Matrix3d::Identity()});
  for (TimeNs stamp = 0; stamp < to_nanoseconds(60.0); stamp += to_nanoseconds(0.1)) {
    const Eigen::Array3d slip = wheel_sigma * Eigen::Array3d::NullaryExpr([&] { return random.normal(); });
    truth = truth * step * Se2::exp(slip);
    wheels_alone = wheels_alone * step;
    slam->predict({step, wheel_sigma.square().matrix().asDiagonal()});

    std::vector<Observation<Planar>> seen;
    for (const Eigen::Vector2d& post : posts_in_map) {
      const Eigen::Vector2d post_in_robot = truth.inverse() * post;
      if (post_in_robot.norm() > range) continue;
      Observation<Planar>& sighting = seen.emplace_back();
      sighting.position_in_base =
          post_in_robot + sensor_sigma * Eigen::Vector2d(random.normal(), random.normal());
      sighting.covariance = sensor_sigma * sensor_sigma * Eigen::Matrix2d::Identity();
    }
    slam->observe(stamp, seen);
  }

  const Eigen::Vector2d robot_in_map = slam->pose().map_from_base.translation();
  std::printf("robot: %.2f m off, by the wheels alone %.2f m\n", (robot_in_map - truth.translation()).norm(),
              (wheels_alone.translation() - truth.translation()).norm());
  for (const LandmarkEstimate<Planar>& post : slam->landmarks()) {
    std::printf("post %d: (%.2f, %.2f) m, sigma (%.2f, %.2f) m\n", post.info.id, post.position_in_map.x(),
                post.position_in_map.y(), std::sqrt(post.covariance(0, 0)), std::sqrt(post.covariance(1, 1)));
  }
}
