#include "kinect_ekf_slam/fusion/path_spline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

struct Path {
  std::vector<TimeNs> stamps;
  std::vector<Eigen::Vector3d> points;
};

/// At uneven times from 0 to `end` s.
template <class Way>
Path sampled(const Way& way, int count, double end) {
  Path path;
  for (int i = 0; i < count; ++i) {
    const double even = static_cast<double>(i) / (count - 1);
    const double t = end * (even + 0.1 * std::sin(2.0 * M_PI * even) / (2.0 * M_PI));
    path.stamps.push_back(to_nanoseconds(t));
    path.points.push_back(way(t));
  }
  return path;
}

Eigen::Vector3d helix(double t) { return {std::cos(0.5 * t), std::sin(0.5 * t), 0.1 * t}; }
Eigen::Vector3d cubic(double t) { return {1.0 + t, 2.0 - t * t, 0.1 * t * t * t}; }

TEST(PathSpline, PassesThroughItsPoints) {
  const Path path = sampled(helix, 40, 20.0);
  const PathSpline<3> spline(path.stamps, path.points);
  for (std::size_t i = 0; i < path.stamps.size(); ++i) {
    EXPECT_TRUE(MatrixNear(spline.position(path.stamps[i]), path.points[i], 1e-12));
  }
}

TEST(PathSpline, IsACubicWhereThePathIsOne) {
  const Path path = sampled(cubic, 12, 5.0);
  const PathSpline<3> spline(path.stamps, path.points);
  for (double t = 0.0; t <= 5.0; t += 0.1) {
    EXPECT_TRUE(MatrixNear(spline.position(to_nanoseconds(t)), cubic(t), 1e-8));
  }
}

TEST(PathSpline, FollowsASmoothPathBetweenItsPoints) {
  const Path path = sampled(helix, 40, 20.0);
  const PathSpline<3> spline(path.stamps, path.points);
  for (double t = 0.0; t <= 20.0; t += 0.05) {
    EXPECT_LT((spline.position(to_nanoseconds(t)) - helix(t)).norm(), 1e-3);
  }
}

TEST(PathSpline, OfFewPointsIsOfALowerDegree) {
  const auto line = [](double t) { return Eigen::Vector3d(t, 2.0 * t, -t); };
  for (const int count : {2, 3}) {
    const Path path = sampled(line, count, 1.0);
    EXPECT_TRUE(
        MatrixNear(PathSpline<3>(path.stamps, path.points).position(to_nanoseconds(0.3)), line(0.3), 1e-9));
  }
  const PathSpline<3> point({to_nanoseconds(7.0)}, {Eigen::Vector3d(1.0, 2.0, 3.0)});
  EXPECT_TRUE(MatrixNear(point.position(to_nanoseconds(7.0)), Eigen::Vector3d(1.0, 2.0, 3.0), 0.0));
  EXPECT_FALSE(point.covers(to_nanoseconds(7.1)));
}

TEST(PathSpline, IsTheWeightedSumOfItsPoints) {
  const Path path = sampled(helix, 25, 10.0);
  const PathSpline<3> spline(path.stamps, path.points);
  const TimeNs stamp = to_nanoseconds(4.321);
  const Eigen::MatrixXd weights = spline.weights({stamp, path.stamps[3]});
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < path.points.size(); ++i)
    sum += weights(0, static_cast<int>(i)) * path.points[i];
  EXPECT_TRUE(MatrixNear(sum, spline.position(stamp), 1e-12));
  EXPECT_NEAR(weights.row(0).sum(), 1.0, 1e-12);
  EXPECT_TRUE(MatrixNear(weights.row(1), Eigen::RowVectorXd::Unit(25, 3), 1e-12));
}

/// Of points with independent errors; at a point it is that point's.
TEST(PathSpline, TellsTheCovarianceThatManyPathsShow) {
  const Path path = sampled(helix, 10, 10.0);
  std::vector<Eigen::Matrix3d> covariances;
  for (int i = 0; i < 10; ++i) covariances.push_back(Eigen::Vector3d(1.0, 2.0, 0.5 + i).asDiagonal());
  const PathSpline<3> spline(path.stamps, path.points);
  EXPECT_TRUE(MatrixNear(spline.covariance(path.stamps[4], covariances), covariances[4], 1e-9));

  const TimeNs stamp = to_nanoseconds(4.9);
  RandomStream random(1, 0);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  const int runs = 10000;
  for (int run = 0; run < runs; ++run) {
    std::vector<Eigen::Vector3d> points = path.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        points[i](axis) += std::sqrt(covariances[i](axis, axis)) * random.normal();
      }
    }
    const Eigen::Vector3d error = PathSpline<3>(path.stamps, points).position(stamp) - spline.position(stamp);
    sum += error * error.transpose() / runs;
  }
  const Eigen::Matrix3d told = spline.covariance(stamp, covariances);
  for (int axis = 0; axis < 3; ++axis) {  // the variance of a variance from n runs is 2 / n of its square
    EXPECT_NEAR(sum(axis, axis) / told(axis, axis), 1.0, 4.0 * std::sqrt(2.0 / runs));
  }
}

TEST(PathSpline, RefusesTimesThatDoNotAscendAndUnequalNumbers) {
  const Eigen::Vector3d p = Eigen::Vector3d::Zero();
  EXPECT_THROW(PathSpline<3>({0, 2, 2}, {p, p, p}), std::invalid_argument);
  EXPECT_THROW(PathSpline<3>({0, 1}, {p}), std::invalid_argument);
  EXPECT_THROW(PathSpline<3>({}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace kinect_ekf_slam
