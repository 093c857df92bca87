#include "kinect_ekf_slam/perception/laser_cylinder.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

constexpr int kRays = 360;
constexpr float kNothing = std::numeric_limits<float>::infinity();

struct Post {
  Eigen::Vector2d place;
  double radius;
};
struct Wall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

LaserCylinderOptions options() {
  LaserCylinderOptions options;
  options.radius = {0.10, 0.20};
  return options;
}

LaserScan empty_scan() {
  LaserScan scan;
  scan.ranges.assign(kRays, kNothing);
  scan.angle_increment = radians(1.0);
  scan.range_min = 0.12;
  scan.range_max = 3.5;
  return scan;
}

double distance_to(const Post& post, const Eigen::Vector2d& ray) {
  const double along = ray.dot(post.place);
  const double aside = ray.x() * post.place.y() - ray.y() * post.place.x();
  if (along < 0.0 || std::abs(aside) >= post.radius) return kNothing;
  return along - std::sqrt(post.radius * post.radius - aside * aside);
}

double distance_to(const Wall& wall, const Eigen::Vector2d& ray) {
  const Eigen::Vector2d along = wall.to - wall.from;
  const double cross = ray.x() * along.y() - ray.y() * along.x();
  if (std::abs(cross) < 1e-9) return kNothing;
  const double distance = (wall.from.x() * along.y() - wall.from.y() * along.x()) / cross;
  const double share = (wall.from.x() * ray.y() - wall.from.y() * ray.x()) / cross;
  return distance > 0.0 && share >= 0.0 && share <= 1.0 ? distance : kNothing;
}

LaserScan scan_of(const std::vector<Post>& posts, const std::vector<Wall>& walls = {}, double sigma = 0.0,
                  std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  LaserScan scan = empty_scan();
  for (int i = 0; i < kRays; ++i) {
    const Eigen::Vector2d ray(std::cos(scan.angle(i)), std::sin(scan.angle(i)));
    double range = kNothing;
    for (const Post& post : posts) range = std::min(range, distance_to(post, ray));
    for (const Wall& wall : walls) range = std::min(range, distance_to(wall, ray));
    range += sigma * normal(random);
    if (range <= scan.range_max) scan.ranges[i] = static_cast<float>(range);
  }
  return scan;
}

TEST(LaserCylinder, FindsFreeCylindersAlsoAcrossTheEndsOfTheScan) {
  const std::vector<Post> posts{{{1.0, 0.0}, 0.15}, {{-1.5, 0.8}, 0.12}, {{0.2, -2.0}, 0.18}};
  const Findings findings = find_cylinders(scan_of(posts), options());
  ASSERT_EQ(findings.found.size(), posts.size());
  for (const Post& post : posts) {
    double nearest = kNothing;
    double radius = 0.0;
    for (const Finding& finding : findings.found) {
      const double distance = (finding.position.head<2>() - post.place).norm();
      if (distance < nearest) radius = finding.signature.radius;
      nearest = std::min(nearest, distance);
      EXPECT_TRUE(testing::IsCovariance(finding.covariance));
      EXPECT_GT(finding.covariance.diagonal().minCoeff(), 0.0);
    }
    EXPECT_LT(nearest, 0.02);
    EXPECT_NEAR(radius, post.radius, 0.02);
  }
}

TEST(LaserCylinder, RefusesWallsAndCorners) {
  const std::vector<std::vector<Wall>> scenes{
      {{{2, -2}, {2, 2}}},                                 // a wall
      {{{1.5, -0.12}, {1.5, 0.12}}},                       // a board
      {{{2.6, -0.6}, {2.2, 0}}, {{2.2, 0}, {2.6, 0.6}}},   // a corner towards the scanner
      {{{2.2, -0.3}, {2.5, 0}}, {{2.5, 0}, {2.2, 0.3}}}};  // and away from it
  for (const auto& walls : scenes) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      EXPECT_TRUE(find_cylinders(scan_of({}, walls, 0.01, seed), options()).found.empty());
    }
  }
}

TEST(LaserCylinder, RefusesTheWrongSizeTheHiddenAndTheTooFarWithAReason) {
  const auto refused = [](const LaserScan& scan) {
    const Findings findings = find_cylinders(scan, options());
    return findings.found.empty();
  };
  EXPECT_TRUE(refused(scan_of({{{1.5, 0.0}, 0.35}})));
  EXPECT_TRUE(refused(scan_of({{{1.0, 0.0}, 0.04}})));
  EXPECT_TRUE(refused(scan_of({{{3.45, 0.0}, 0.15}})));
  EXPECT_FALSE(refused(scan_of({{{1.5, 0.0}, 0.15}})));
  const LaserScan hidden = scan_of({{{1.5, 0.0}, 0.15}}, {{{0.8, -0.4}, {0.8, -0.065}}});
  EXPECT_TRUE(refused(hidden));
  ASSERT_FALSE(find_cylinders(hidden, options()).refused.empty());
  EXPECT_EQ(find_cylinders(hidden, options()).refused.back().reason, "partly hidden");
}

TEST(LaserCylinder, KnowsItsError) {
  double squared = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Post post{{1.6, 0.3}, 0.15};
    for (const Finding& finding : find_cylinders(scan_of({post}, {}, 0.01, seed), options()).found) {
      const Eigen::Vector2d error = finding.position.head<2>() - post.place;
      const Eigen::Matrix2d covariance = finding.covariance.topLeftCorner<2, 2>();
      squared += error.dot(covariance.ldlt().solve(error));
      ++count;
    }
  }
  ASSERT_GT(count, 250);
  EXPECT_LT(squared / count, 2.4);  // 2 expected; the radius is the mean of what is thought possible
  EXPECT_GT(squared / count, 0.8);
}

TEST(LaserCylinder, AnEmptyScanHasNone) {
  EXPECT_TRUE(find_cylinders(LaserScan(), options()).found.empty());
  EXPECT_TRUE(find_cylinders(empty_scan(), options()).found.empty());
  LaserScan scan = empty_scan();
  scan.ranges.assign(kRays, std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(find_cylinders(scan, options()).found.empty());
}

}  // namespace
}  // namespace kinect_ekf_slam
