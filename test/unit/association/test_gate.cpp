#include "kinect_ekf_slam/association/gate.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "kinect_ekf_slam/association/nearest_neighbor.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "test/support/fake_map.h"

namespace kinect_ekf_slam {
namespace {

/// Of sightings that err as their covariance says, the gate refuses the share that is named.
TEST(Gate, RefusesAsManyAsItSays) {
  for (const double probability : {0.9, 0.975, 0.999}) {
    AssociationOptions options;
    options.gate_probability = probability;
    const NearestNeighbor<Planar> associator(options);
    testing::FakeMap map;
    map.add({2.0, 0.5});
    Eigen::Matrix2d expected_covariance;
    expected_covariance << 0.04, 0.01, 0.01, 0.02;
    map.set_covariance(0, expected_covariance);
    RandomStream random(1, 0);
    const int sightings = 40000;
    int refused = 0;
    for (int i = 0; i < sightings; ++i) {
      Observation<Planar> seen = testing::sighting({2.0, 0.5}, kNoId, 0.1);
      const Eigen::Matrix2d S = expected_covariance + seen.covariance;
      const double first = random.normal();
      const double second = random.normal();
      seen.position_in_base += S.llt().matrixL() * Eigen::Vector2d(first, second);
      if (associator.associate({seen}, map)[0].verdict != Verdict::kMatched) ++refused;
    }
    const double share = 1.0 - probability;
    const double sigma = std::sqrt(share * (1.0 - share) / sightings);
    EXPECT_NEAR(refused / static_cast<double>(sightings), share, 4.0 * sigma) << probability;
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
