#include "kinect_ekf_slam/core/local_tangent_plane.h"

#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

TEST(LocalTangentPlane, HasTheDatumAsItsOrigin) {
  const Geodetic datum{42.375812, -71.147394, 7.3};
  EXPECT_TRUE(MatrixNear(LocalTangentPlane(datum)(datum), Eigen::Vector3d::Zero(), 1e-9));
}

/// At the equator the radii of curvature are a (1 - e^2) along the meridian and a along the equator.
TEST(LocalTangentPlane, ASmallStepIsAsLongAsTheEarthIsCurved) {
  const LocalTangentPlane plane({0.0, 30.0, 0.0});
  const double step = 1e-4;  // deg
  const double e2 = 0.00669437999014;
  EXPECT_NEAR(plane({step, 30.0, 0.0}).y(), 6378137.0 * (1.0 - e2) * radians(step), 1e-4);
  EXPECT_NEAR(plane({0.0, 30.0 + step, 0.0}).x(), 6378137.0 * radians(step), 1e-4);
  EXPECT_TRUE(MatrixNear(plane({0.0, 30.0, 12.0}), Eigen::Vector3d(0.0, 0.0, 12.0), 1e-6));
}

TEST(LocalTangentPlane, FallsAwayBelowThePlane) {
  const LocalTangentPlane plane({52.0, 0.0, 0.0});
  const Eigen::Vector3d far = plane({52.1, 0.0, 0.0});  // 11 km: d^2 / 2 R below
  EXPECT_NEAR(far.y(), 11126.0, 5.0);
  EXPECT_NEAR(far.z(), -far.y() * far.y() / (2.0 * 6375000.0), 0.1);
}

TEST(LocalTangentPlane, CrossesTheDateLine) {
  const LocalTangentPlane plane({10.0, 179.9999, 0.0});
  EXPECT_NEAR(plane({10.0, -179.9999, 0.0}).x(), 21.93, 0.05);
}

}  // namespace
}  // namespace kinect_ekf_slam
