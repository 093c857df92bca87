/// Does the covariance tell the truth? Many seeds, bounds by the chi-square distribution.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/estimators/ekf.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::AngleNear;
using testing::IsCovariance;
using testing::MatrixNear;
using testing::motion;
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

TEST(LongRun, StaysSymmetricAndPositiveDefinite) {
  Scenario<Planar> scenario(2, 20, 3.0);
  scenario.range = 3.5;
  scenario.motion_sigma = 0.002;
  const PoseEstimate<Planar> initial = pose_at<Planar>(Se2(), 1e-3);
  scenario.start_at(initial);
  const auto ekf = make(initial);
  for (int i = 1; i <= 100000; ++i) {
    ekf->predict(scenario.drive({0.05, 0.0, 0.02}));
    ekf->observe(i, scenario.look());
    if (i % 5000 != 0) continue;
    const SlamState<Planar> state = ekf->snapshot();
    ASSERT_TRUE(state.covariance.allFinite());
    ASSERT_EQ(state.covariance, state.covariance.transpose()) << i;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(state.covariance);
    ASSERT_GT(solver.eigenvalues().minCoeff(), 0.0) << i;
  }
  EXPECT_EQ(ekf->landmarks().size(), 20U);
}

/// A sensor far from the robot's centre that looks backwards: its sightings, brought into the base, converge.
TEST(Convergence, WithASensorFarFromTheCentreAndTurned) {
  const Se2 base_from_sensor(-2.0, 0.7, kPi);
  const Se2 true_start(0.0, 0.0, 0.0);
  const std::vector<Eigen::Vector2d> landmarks = {{-3.5, 0.5}, {-4.0, 1.5}, {-3.0, 2.0}};
  const auto ekf = make(pose_at<Planar>(true_start, 1e-3));
  Scenario<Planar> noise(3, 0);
  Se2 truth = true_start;
  for (int i = 0; i < 400; ++i) {
    const MotionStep<Planar> step = motion<Planar>(Se2::exp({0.01, 0.0, 0.03}), 2e-3);
    truth = truth * step.delta * Se2::exp(noise.draw(step.covariance));
    ekf->predict(step);
    std::vector<Observation<Planar>> observations;
    for (std::size_t k = 0; k < landmarks.size(); ++k) {
      Eigen::Vector2d in_sensor = (truth * base_from_sensor).inverse() * landmarks[k];
      auto observation = testing::seen<Planar>({0.0, 0.0}, static_cast<int>(k), 0.02);
      in_sensor += noise.draw(observation.covariance);
      observation.position_in_base = base_from_sensor * in_sensor;
      observations.push_back(observation);
    }
    ekf->observe(1 + i, observations);
  }
  EXPECT_TRUE(MatrixNear(ekf->pose().map_from_base.translation(), truth.translation(), 0.03));
  EXPECT_TRUE(AngleNear(ekf->pose().map_from_base.angle(), truth.angle(), 0.015));
  ASSERT_EQ(ekf->landmarks().size(), landmarks.size());
  for (const auto& landmark : ekf->landmarks()) {
    EXPECT_TRUE(MatrixNear(landmark.position_in_map, landmarks[landmark.info.source_id], 0.03));
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
