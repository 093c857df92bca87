/// Does the covariance tell the truth? Many seeds, bounds by the chi-square distribution.
#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/estimators/ekf.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::pose_at;
using testing::Scenario;
using testing::textbook;

constexpr int kPoseDof = 3;

/// The mean of `count` values of NEES lies in its 95 % bounds.
::testing::AssertionResult IsConsistent(double mean_nees, int count) {
  const double low = chi_square_quantile(0.025, kPoseDof * count) / count;
  const double high = chi_square_quantile(0.975, kPoseDof * count) / count;
  if (low <= mean_nees && mean_nees <= high) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "mean NEES " << mean_nees << " outside [" << low << ", " << high << "]";
}

std::unique_ptr<SlamEstimator<Planar>> make(const PoseEstimate<Planar>& initial) {
  return make_estimator<Planar>(textbook(), testing::known_identities(), initial);
}

TEST(Consistency, OfAShortRun) {
  const int seeds = 50;
  double sum = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Scenario<Planar> scenario(seed, 12);
    const PoseEstimate<Planar> initial = pose_at<Planar>(Se2(), 0.01);
    scenario.start_at(initial);
    const auto ekf = make(initial);
    for (int i = 0; i < 30; ++i) {
      ekf->predict(scenario.drive(testing::gentle_curve<Planar>()));
      ekf->observe(1 + i, scenario.look());
    }
    sum += testing::nees(scenario, ekf->pose());
  }
  EXPECT_TRUE(IsConsistent(sum / seeds, seeds));
}

/// The innovations are as large as the filter says.
TEST(Consistency, OfTheInnovations) {
  double sum = 0.0;
  int dof = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    Scenario<Planar> scenario(seed, 12);
    const PoseEstimate<Planar> initial = pose_at<Planar>(Se2(), 0.01);
    scenario.start_at(initial);
    const auto ekf = make(initial);
    for (int i = 0; i < 30; ++i) {
      ekf->predict(scenario.drive(testing::gentle_curve<Planar>()));
      const UpdateReport report = ekf->observe(1 + i, scenario.look());
      if (report.dof > 0) sum += report.nis;
      dof += report.dof;
    }
  }
  EXPECT_GT(sum, chi_square_quantile(0.005, dof));
  EXPECT_LT(sum, chi_square_quantile(0.995, dof));
}

/// Schmidt's filter: the map is fixed and wrong by as much as it says; the pose's covariance accounts for it.
TEST(Consistency, OfLocalisationInAnUncertainMap) {
  const int seeds = 200;
  double sum = 0.0;
  double sum_of_naive = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Scenario<Planar> scenario(seed, 10);
    SlamState<Planar> map;
    map.landmarks_in_map.resize(20);
    map.covariance = 0.1 * 0.1 * Eigen::MatrixXd::Identity(23, 23);
    map.covariance.bottomRightCorner(20, 20).array() +=
        0.05 * 0.05;  // all are off in the same direction, too
    map.covariance.topLeftCorner(3, 3) = 0.05 * 0.05 * Eigen::Matrix3d::Identity();
    const Eigen::VectorXd error = scenario.draw(Eigen::MatrixXd(map.covariance.bottomRightCorner(20, 20)));
    for (int i = 0; i < 10; ++i) {
      map.infos.emplace_back();
      map.infos.back().id = map.infos.back().source_id = i;
      map.landmarks_in_map.segment<2>(2 * i) = scenario.landmarks()[i] + error.segment<2>(2 * i);
    }
    scenario.start_at(pose_at<Planar>(Se2(), 0.05));
    const auto localisation = make(pose_at<Planar>(Se2(), 0.05));
    localisation->restore(map);
    localisation->set_map_fixed(true);
    const auto naive = localisation->clone();  // believes the map to be exact
    map.covariance.bottomRightCorner(20, 20) = 1e-12 * Eigen::MatrixXd::Identity(20, 20);
    naive->restore(map);
    for (int i = 0; i < 30; ++i) {
      const auto step = scenario.drive(testing::gentle_curve<Planar>());
      const auto sightings = scenario.look();
      localisation->predict(step);
      localisation->observe(1 + i, sightings);
      naive->predict(step);
      naive->observe(1 + i, sightings);
    }
    EXPECT_TRUE(IsCovariance(localisation->snapshot().covariance));
    sum += testing::nees(scenario, localisation->pose());
    sum_of_naive += testing::nees(scenario, naive->pose());
  }
  EXPECT_TRUE(IsConsistent(sum / seeds, seeds));
  EXPECT_GT(sum_of_naive / seeds, 6.0) << "the test would not notice a map that is taken for exact";
}

}  // namespace
}  // namespace kinect_ekf_slam
