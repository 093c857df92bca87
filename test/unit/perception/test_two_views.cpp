#include "kinect_ekf_slam/perception/two_views.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/core/se3.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

const PinholeCamera kCamera;

Eigen::Isometry3d motion_of(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translation() = translation;
  motion.linear() = rotation_exp(rotation).toRotationMatrix();
  return motion;
}

const Eigen::Isometry3d kSecondFromFirst = motion_of({0.25, -0.03, 0.06}, {0.02, -0.08, 0.03});

Eigen::Vector3d normal_vector(RandomStream* random) {
  const double x = random->normal();
  const double y = random->normal();
  return {x, y, random->normal()};
}

Eigen::Vector2d noisy(const Eigen::Vector2d& pixel, double sigma, RandomStream* random) {
  const double right = sigma * random->normal();
  return pixel + Eigen::Vector2d(right, sigma * random->normal());
}

/// Points that both pictures show, noisy places in the first and noisy pixels in the second.
struct Sample {
  std::vector<PlacedPoint> places;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector2d> pixels_in_first;
  std::vector<Eigen::Vector3d> true_in_second;

  Sample(int count, double pixel_sigma, double depth_sigma, RandomStream* random) {
    for (int i = 0; i < count; ++i) {
      const double column = random->uniform(40.0, 600.0);
      const double row = random->uniform(40.0, 440.0);
      const Eigen::Vector3d ray = kCamera.ray(column, row);
      const Eigen::Vector3d point = random->uniform(1.0, 3.5) * ray;
      PlacedPoint place;
      place.covariance = depth_sigma * depth_sigma * Eigen::Matrix3d::Identity();
      place.position = point + depth_sigma * normal_vector(random);
      places.push_back(place);
      true_in_second.push_back(kSecondFromFirst * point);
      pixels_in_first.push_back(noisy(kCamera.project(point), pixel_sigma, random));
      pixels.push_back(noisy(kCamera.project(true_in_second.back()), pixel_sigma, random));
    }
  }
};

TEST(TwoViews, MotionIsExactWithoutNoise) {
  RandomStream random(1, 0);
  const Sample sample(30, 0.0, 0.0, &random);
  const auto motion = find_motion(sample.places, sample.pixels, kCamera, {});
  ASSERT_TRUE(motion);
  EXPECT_TRUE(testing::MatrixNear(motion->second_from_first.matrix(), kSecondFromFirst.matrix(), 1e-7));
}

TEST(TwoViews, MotionIsAsGoodAsItSays) {
  constexpr int kRuns = 300;
  double nees = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(run, 0);
    const Sample sample(40, 1.0, 0.01, &random);
    const auto motion = find_motion(sample.places, sample.pixels, kCamera, {});
    ASSERT_TRUE(motion);
    const Eigen::Isometry3d off = kSecondFromFirst * motion->second_from_first.inverse();
    Eigen::Matrix<double, 6, 1> error;
    error << off.translation(), rotation_log(Eigen::Quaterniond(off.linear()));
    nees += error.dot(motion->covariance.ldlt().solve(error)) / kRuns;
  }
  EXPECT_GT(nees, 5.4);  // 6 when consistent; the mean of 300 has a sigma of 0.2
  EXPECT_LT(nees, 6.8);  // outliers by chance are left out, which costs a little
}

TEST(TwoViews, PointsThatMoveByThemselvesDoNotAgree) {
  RandomStream random(5, 0);
  Sample sample(40, 0.5, 0.005, &random);
  for (int i = 0; i < 12; ++i) sample.pixels[i] += Eigen::Vector2d(20.0 + i, -15.0);
  const auto motion = find_motion(sample.places, sample.pixels, kCamera, {});
  ASSERT_TRUE(motion);
  EXPECT_TRUE(testing::MatrixNear(motion->second_from_first.matrix(), kSecondFromFirst.matrix(), 0.02));
  for (int i = 0; i < 40; ++i) EXPECT_EQ(motion->agrees[i], i >= 12) << i;
}

TEST(TwoViews, TooFewPointsTellNoMotion) {
  RandomStream random(5, 0);
  const Sample sample(7, 0.0, 0.0, &random);
  EXPECT_FALSE(find_motion(sample.places, sample.pixels, kCamera, {}));
  EXPECT_FALSE(find_motion({}, {}, kCamera, {}));
}

TEST(TwoViews, TriangulatedPlacesAreAsGoodAsTheySay) {
  constexpr int kRuns = 2000;
  double nees = 0.0;
  int count = 0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(run, 0);
    const Sample sample(1, 1.0, 0.0, &random);
    CameraMotion motion;
    motion.covariance.diagonal() << Eigen::Vector3d::Constant(4e-6), Eigen::Vector3d::Constant(1e-6);
    const Eigen::Isometry3d off = motion_of(2e-3 * normal_vector(&random), 1e-3 * normal_vector(&random));
    motion.second_from_first = off * kSecondFromFirst;
    const auto place = triangulate(sample.pixels_in_first[0], sample.pixels[0], motion, kCamera, {});
    if (!place) continue;
    const Eigen::Vector3d error = place->position - sample.true_in_second[0];
    nees += error.dot(place->covariance.ldlt().solve(error));
    ++count;
  }
  EXPECT_GT(count, kRuns / 2);
  EXPECT_GT(nees / count, 2.7);  // 3 when consistent
  EXPECT_LT(nees / count, 3.3);
}

TEST(TwoViews, WithoutABaselineThereIsNoPlace) {
  CameraMotion motion;
  const Eigen::Vector2d pixel(300.0, 200.0);
  EXPECT_FALSE(triangulate(pixel, pixel, motion, kCamera, {}));
  motion.second_from_first.translation().x() = 0.001;
  EXPECT_FALSE(triangulate(pixel, pixel + Eigen::Vector2d(0.3, 0.0), motion, kCamera, {}));
  motion.second_from_first.translation().x() = 0.3;  // rays that part in front meet behind the cameras
  EXPECT_FALSE(triangulate(pixel, pixel - Eigen::Vector2d(50.0, 0.0), motion, kCamera, {}));
}

}  // namespace
}  // namespace kinect_ekf_slam
