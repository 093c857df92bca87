#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "kinect_ekf_slam/core/chi_square.h"
#include "test/support/batch_scenario.h"
#include "test/support/matchers.h"
#include "test/support/spaces.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::BatchScenario;
using testing::MatrixNear;
using testing::message_of;
using testing::numerical_jacobian;
using testing::PoseNear;

template <class Space>
class Smoothing : public ::testing::Test {};
TYPED_TEST_SUITE(Smoothing, testing::Spaces, testing::SpaceNames);

TYPED_TEST(Smoothing, IncrementsKnowHowTheyChangeWithTheCalibration) {
  using Space = TypeParam;
  std::vector<RecordedVelocity> velocities;
  for (int k = 0; k < 30; ++k) {
    BodyVelocity velocity;
    velocity.linear << 0.4, 0.02, 0.0;
    velocity.angular << 0.05, -0.02, std::sin(0.3 * k);
    velocities.push_back({to_nanoseconds(0.1 * k), velocity, 1.0});
  }
  OdometryTrack<Space> track(velocities, {});
  const MotionCalibration at(0.1, -0.05, 0.03);
  // Not at a stamp: the delay's derivative is that of a velocity that holds.
  const TimeNs from = to_nanoseconds(0.57);
  const TimeNs to = to_nanoseconds(2.21);
  track.set_calibration(at);
  const Increment<Space> increment = track.between(from, to);
  const Eigen::MatrixXd numerical = numerical_jacobian(
      [&](const Eigen::VectorXd& calibration) -> Eigen::VectorXd {
        track.set_calibration(calibration);
        return (increment.delta.inverse() * track.between(from, to).delta).log();
      },
      at, 1e-4);
  EXPECT_TRUE(MatrixNear(increment.by_calibration, numerical, 1e-5));
}

TYPED_TEST(Smoothing, IncrementsAddUp) {
  using Space = TypeParam;
  const BatchScenario<Space> scenario(1);
  OdometryTrack<Space> track(scenario.run.velocities, scenario.options.motion);
  const TimeNs from = to_nanoseconds(103.02);
  const TimeNs middle = to_nanoseconds(104.57);
  const TimeNs to = to_nanoseconds(106.0);
  const Increment<Space> first = track.between(from, middle);
  const Increment<Space> second = track.between(middle, to);
  const Increment<Space> whole = track.between(from, to);
  EXPECT_TRUE(PoseNear(whole.delta, first.delta * second.delta, 1e-9));
  const auto carried = second.delta.inverse().adjoint();
  EXPECT_TRUE(MatrixNear(whole.covariance,
                         carried * first.covariance * carried.transpose() + second.covariance, 1e-6));
}

TYPED_TEST(Smoothing, IncrementsWithoutOdometryKnowNothing) {
  using Space = TypeParam;
  BodyVelocity velocity;
  velocity.linear.x() = 0.5;
  const std::vector<RecordedVelocity> velocities = {{0, velocity, 1.0}};
  const OdometryTrack<Space> track(velocities, {});
  const Increment<Space> increment = track.between(0, to_nanoseconds(5.0));
  EXPECT_NEAR(increment.delta.translation().x(), 0.5, 1e-9) << "held for one second";
  EXPECT_GT(increment.covariance(0, 0), 4.0 * 0.25);
}

TYPED_TEST(Smoothing, ThePathBetweenTwoKnotsEndsInThem) {
  using Space = TypeParam;
  using Pose = typename Space::Pose;
  const BatchScenario<Space> scenario(2);
  const OdometryTrack<Space> track(scenario.run.velocities, scenario.options.motion);
  std::vector<typename SmoothedPath<Space>::Knot> knots(2);
  knots[0].stamp = to_nanoseconds(101.0);
  knots[1].stamp = to_nanoseconds(102.0);
  const Increment<Space> whole = track.between(knots[0].stamp, knots[1].stamp);
  const typename Space::PoseVector bent = Space::PoseVector::Constant(0.02);
  knots[1].map_from_base = whole.delta * Pose::exp(bent);
  for (auto& knot : knots) knot.covariance = 1e-4 * Space::PoseMatrix::Identity();
  const SmoothedPath<Space> path(track, knots);
  EXPECT_TRUE(PoseNear(path.at(knots[0].stamp).map_from_base, knots[0].map_from_base, 1e-9));
  EXPECT_TRUE(PoseNear(path.at(knots[1].stamp - 1).map_from_base, knots[1].map_from_base, 1e-4));
  // Half of what is left over falls to the first half: the noise hardly changes on the way.
  const TimeNs middle = to_nanoseconds(101.5);
  const auto half =
      (track.between(knots[0].stamp, middle).delta.inverse() * path.at(middle).map_from_base).log();
  EXPECT_NEAR(half(Space::kPoseDim - 1), 0.5 * bent(Space::kPoseDim - 1), 0.2 * bent(Space::kPoseDim - 1));
  // Known at both ends, unknown in between; more unknown beyond.
  const double at_knot = path.at(knots[0].stamp).covariance.trace();
  const double between = path.at(middle).covariance.trace();
  EXPECT_LT(between, track.between(knots[0].stamp, middle).covariance.trace() + at_knot);
  EXPECT_GT(path.at(to_nanoseconds(104.0)).covariance.trace(), between);
  EXPECT_GT(path.at(to_nanoseconds(100.0)).covariance.trace(), at_knot);
}

/// Sum of e^T P^-1 e over seeds, of calibrations and of landmarks.
template <class Space>
struct Consistency {
  double calibration = 0.0;
  double calibration_dof = 0.0;
  double landmarks = 0.0;
  double landmarks_dof = 0.0;
  double poses = 0.0;
  double poses_dof = 0.0;

  void add(const BatchScenario<Space>& scenario, const BatchResult<Space>& result) {
    Eigen::VectorXd error(Calibration<Space>::kUnknowns);
    error << result.calibration.motion - scenario.calibration.motion,
        result.calibration.sensor - scenario.calibration.sensor;
    calibration += error.dot(result.calibration_covariance.ldlt().solve(error));
    calibration_dof += static_cast<double>(error.size());
    for (std::size_t i = 0; i < scenario.landmarks.size(); ++i) {
      const typename Space::Point off = result.landmarks[i].in_map - scenario.landmarks[i];
      landmarks += off.dot(result.landmarks[i].covariance.ldlt().solve(off));
      landmarks_dof += Space::kPointDim;
    }
    for (std::size_t k = 3; k < scenario.path.size(); k += 50) {  // between two knots
      const PoseEstimate<Space> estimate = result.path.at(scenario.path[k].stamp);
      const auto off = pose_error<Space>(estimate.map_from_base, scenario.path[k].map_from_base);
      poses += off.dot(estimate.covariance.ldlt().solve(off));
      poses_dof += Space::kPoseDim;
    }
  }
};

TYPED_TEST(Smoothing, RecoversACalibrationAsSurelyAsItSays) {
  using Space = TypeParam;
  constexpr int kSeeds = Space::kPointDim == 2 ? 100 : 40;
  Consistency<Space> consistency;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    BatchScenario<Space> scenario(seed);
    scenario.options.loss_scale = BatchOptions().loss_scale;
    const BatchResult<Space> result = batch_optimum(scenario.run, scenario.options);
    EXPECT_TRUE(result.converged) << "seed " << seed;
    consistency.add(scenario, result);
    // What the run tells well is known far better than before it.
    const Calibration<Space> prior = sigmas<Space>(scenario.options.prior);
    EXPECT_LT(std::sqrt(result.calibration_covariance(kMotionUnknowns + kDepthShare,
                                                      kMotionUnknowns + kDepthShare)),
              0.3 * prior.sensor(kDepthShare));
  }
  // The calibrations of the seeds are independent: chi-square bounds.
  EXPECT_GT(consistency.calibration, chi_square_quantile(0.001, consistency.calibration_dof));
  EXPECT_LT(consistency.calibration, chi_square_quantile(0.999, consistency.calibration_dof));
  // Landmarks and poses of one seed are not: their mean over the seeds has a sigma of 0.05 to 0.11.
  EXPECT_NEAR(consistency.landmarks / consistency.landmarks_dof, 1.0, 0.25);
  EXPECT_NEAR(consistency.poses / consistency.poses_dof, 1.0, 0.25);
}

TEST(Batch, HardlyBelievesWrongIdentities) {
  BatchScenario<Planar> scenario(3);
  const BatchResult<Planar> clean = batch_optimum(scenario.run, scenario.options);
  scenario.options.loss_scale = BatchOptions().loss_scale;
  std::vector<std::size_t> wrong;
  for (std::size_t i = 7; i < scenario.run.sightings.size(); i += 20) {
    scenario.run.sightings[i].landmark = (scenario.run.sightings[i].landmark + 5) % 12;
    wrong.push_back(i);
  }
  const BatchResult<Planar> result = batch_optimum(scenario.run, scenario.options);
  ASSERT_GT(wrong.size(), 10U);
  for (const std::size_t i : wrong) EXPECT_LT(result.sightings[i].weight, 0.1) << "sighting " << i;
  double mean_weight = 0.0;
  for (const SightingOutcome& outcome : result.sightings) mean_weight += outcome.weight;
  EXPECT_GT(mean_weight / static_cast<double>(result.sightings.size()), 0.7) << "and the others it does";
  for (std::size_t i = 0; i < scenario.landmarks.size(); ++i) {
    EXPECT_TRUE(MatrixNear(result.landmarks[i].in_map, clean.landmarks[i].in_map, 0.06)) << "landmark " << i;
  }
}

TEST(Batch, AWorldThatIsScaledIsNotPreferred) {
  // Free scales and noise that grows with the distance: the estimate's size is unbiased over many runs.
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kSeeds = 30;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    BatchScenario<Planar> scenario(seed);
    const BatchResult<Planar> result = batch_optimum(scenario.run, scenario.options);
    const double error =
        result.calibration.motion(kLogLinearScale) - scenario.calibration.motion(kLogLinearScale);
    sum += error;
    squares += error * error;
  }
  EXPECT_LT(std::abs(sum), 3.5 * std::sqrt(squares)) << "mean log scale error " << sum / kSeeds;
}

TEST(Batch, TellsAboutItsProgress) {
  BatchScenario<Planar> scenario(4);
  std::vector<double> shares;
  scenario.options.on_progress = [&shares](double share) { shares.push_back(share); };
  batch_optimum(scenario.run, scenario.options);
  ASSERT_GT(shares.size(), 2U);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1.0);
}

TEST(Batch, SaysWhatARunLacks) {
  const BatchScenario<Planar> scenario(5);
  RecordedRun<Planar> run = scenario.run;
  run.sightings.clear();
  EXPECT_EQ(message_of<std::invalid_argument>([&] { batch_optimum(run, scenario.options); }),
            "the run has no sighting of a landmark");
  run = scenario.run;
  run.path.clear();
  EXPECT_EQ(message_of<std::invalid_argument>([&] { batch_optimum(run, scenario.options); }),
            "the run has no path");
}

}  // namespace
}  // namespace kinect_ekf_slam
