/// What the filter does besides the textbook's equations: doubt, misread identities, singular matrices.
#include <gtest/gtest.h>

#include <limits>

#include "kinect_ekf_slam/estimators/ekf.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::motion;
using testing::pose_at;
using testing::PoseNear;
using testing::textbook;

using Estimator = std::unique_ptr<SlamEstimator<Planar>>;

Observation<Planar> seen(double x, double y, int identity, double sigma = 0.05) {
  return testing::seen<Planar>({x, y}, identity, sigma);
}

Estimator make(const EstimatorOptions& options,
               const AssociationOptions& association = testing::known_identities(), double sigma = 0.1) {
  return make_estimator<Planar>(options, association, pose_at<Planar>(Se2(), sigma));
}

EstimatorOptions robust(double threshold) {
  EstimatorOptions options = textbook();
  options.robust_threshold = threshold;
  return options;
}

EstimatorOptions replacing(int sightings) {
  EstimatorOptions options = textbook();
  options.replace_after = sightings;
  return options;
}

TEST(Robustness, AnUnlikelySightingPullsLess) {
  // The same sighting 0.4 m aside, squared distance far above the threshold.
  double correction[2];
  for (const bool doubts : {false, true}) {
    const Estimator ekf = make(robust(doubts ? 6.0 : 0.0));
    ekf->observe(1, {seen(1.0, 0.0, 1)});
    ekf->predict(motion<Planar>(Se2(), 0.05));
    const UpdateReport report = ekf->observe(2, {seen(1.0, 0.4, 1)});
    ASSERT_EQ(report.assignments[0].verdict, Verdict::kMatched);
    ASSERT_GT(report.assignments[0].squared_distance, 12.0);
    correction[doubts ? 1 : 0] = std::abs(ekf->pose().map_from_base.angle());
  }
  EXPECT_LT(correction[1], 0.8 * correction[0]);
}

TEST(Robustness, ALikelySightingCountsInFull) {
  const Estimator plain = make(robust(0.0));
  const Estimator doubting = make(robust(6.0));
  for (const Estimator* ekf : {&plain, &doubting}) {
    (*ekf)->observe(1, {seen(1.0, 0.0, 1)});
    (*ekf)->predict(motion<Planar>(Se2(), 0.05));
    ASSERT_LT((*ekf)->observe(2, {seen(1.0, 0.05, 1)}).assignments[0].squared_distance, 6.0);
  }
  EXPECT_TRUE(MatrixNear(plain->snapshot().covariance, doubting->snapshot().covariance, 0.0));
  EXPECT_TRUE(PoseNear(plain->pose().map_from_base, doubting->pose().map_from_base, 0.0));
}

TEST(Robustness, NoiseGrowsInProportionToTheDistance) {
  const double threshold = 6.0;
  const Estimator doubting = make(robust(threshold));
  const Estimator plain = make(robust(0.0));
  for (const Estimator* ekf : {&plain, &doubting}) {
    (*ekf)->observe(1, {seen(1.0, 0.0, 1)});
    (*ekf)->predict(motion<Planar>(Se2(), 0.05));
  }
  const double distance = doubting->observe(2, {seen(1.0, 0.4, 1)}).assignments[0].squared_distance;
  plain->observe(2, {seen(1.0, 0.4, 1, 0.05 * std::sqrt(distance / threshold))});
  EXPECT_TRUE(MatrixNear(plain->snapshot().covariance, doubting->snapshot().covariance, 1e-12));
}

TEST(Correlation, SightingsThatComeFastSayLess) {
  const auto sigma_after = [](double correlation_time) {
    const Estimator ekf = make(textbook());
    for (int i = 1; i <= 100; ++i) {  // 10 Hz
      Observation<Planar> sighting = seen(1.0, 0.0, 1);
      sighting.correlation_time = correlation_time;
      ekf->observe(to_nanoseconds(0.1 * i), {sighting});
    }
    const SlamState<Planar> state = ekf->snapshot();  // of the landmark, seen from the robot
    Eigen::MatrixXd H(2, 5);
    H << -1, 0, 0, 1, 0, 0, -1, -1, 0, 1;
    return std::sqrt((H * state.covariance * H.transpose())(0, 0));
  };
  EXPECT_NEAR(sigma_after(0.0), 0.05 / 10.0, 1e-6);
  const double inflation = correlation_inflation(0.1, 1.0);
  EXPECT_NEAR(sigma_after(1.0), 0.05 / std::sqrt(1.0 + 99.0 / inflation), 1e-6);
}

TEST(Replacement, AMisreadIdentityIsPlacedAnew) {
  const Estimator ekf = make(replacing(3), testing::known_identities(0.999), 1e-3);
  const int misread =
      ekf->observe(1, {seen(1.0, 0.0, 1)}).assignments[0].landmark;  // it was another's barcode
  EXPECT_EQ(ekf->observe(2, {seen(3.0, 2.0, 1)}).assignments[0].verdict, Verdict::kOutsideGate);
  EXPECT_EQ(ekf->observe(3, {seen(3.0, 2.0, 1)}).assignments[0].verdict, Verdict::kOutsideGate);
  const UpdateReport report = ekf->observe(4, {seen(3.0, 2.0, 1)});
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kCreated);
  EXPECT_EQ(report.assignments[0].landmark, misread) << "the identity names it again";
  ASSERT_EQ(ekf->landmarks().size(), 1U);
  EXPECT_TRUE(MatrixNear(ekf->landmarks()[0].position_in_map, Eigen::Vector2d(3.0, 2.0), 1e-9));
  EXPECT_EQ(ekf->observe(5, {seen(3.0, 2.0, 1)}).assignments[0].verdict, Verdict::kMatched);
}

TEST(Replacement, AnEstablishedLandmarkIsLeftAlone) {
  const Estimator ekf = make(replacing(3), testing::known_identities(0.999), 1e-3);
  for (int i = 1; i <= 20; ++i) ekf->observe(i, {seen(1.0, 0.0, 1)});
  for (int i = 0; i < 19; ++i) {
    EXPECT_EQ(ekf->observe(30 + i, {seen(3.0, 2.0, 1)}).assignments[0].verdict, Verdict::kOutsideGate) << i;
  }
  EXPECT_TRUE(MatrixNear(ekf->landmarks()[0].position_in_map, Eigen::Vector2d(1.0, 0.0), 1e-6));
}

TEST(Replacement, OneGoodSightingForgivesTheBadOnes) {
  const Estimator ekf = make(replacing(3), testing::known_identities(0.999), 1e-3);
  const int landmark = ekf->observe(1, {seen(1.0, 0.0, 1)}).assignments[0].landmark;
  for (int i = 0; i < 10; ++i) {
    ekf->observe(10 * i + 2, {seen(3.0, 2.0, 1)});
    ekf->observe(10 * i + 3, {seen(3.0, 2.0, 1)});
    EXPECT_EQ(ekf->observe(10 * i + 4, {seen(1.0, 0.0, 1)}).assignments[0].verdict, Verdict::kMatched);
  }
  EXPECT_EQ(ekf->landmarks()[0].info.id, landmark);
}

TEST(Replacement, ZeroMeansNever) {
  const Estimator ekf = make(replacing(0), testing::known_identities(0.999), 1e-3);
  ekf->observe(1, {seen(1.0, 0.0, 1)});
  for (int i = 0; i < 100; ++i) ekf->observe(2 + i, {seen(3.0, 2.0, 1)});
  EXPECT_TRUE(MatrixNear(ekf->landmarks()[0].position_in_map, Eigen::Vector2d(1.0, 0.0), 1e-6));
}

TEST(Replacement, AFixedMapIsNotChanged) {
  const Estimator ekf = make(replacing(1), testing::known_identities(0.999), 1e-3);
  const int landmark = ekf->observe(1, {seen(1.0, 0.0, 1)}).assignments[0].landmark;
  ekf->set_map_fixed(true);
  for (int i = 0; i < 10; ++i) ekf->observe(2 + i, {seen(3.0, 2.0, 1)});
  EXPECT_EQ(ekf->landmarks()[0].info.id, landmark);
}

/// What goes takes its rows and columns with it, and what it said of the others stays with them.
TEST(Replacement, LeavesTheOthersEstimatesAndCovariancesAsTheyWere) {
  const Estimator ekf = make(replacing(1), testing::known_identities(0.999));
  ekf->observe(1, {seen(1.0, 0.0, 1), seen(1.0, 1.0, 2), seen(2.0, -1.0, 3)});
  ekf->predict(motion<Planar>(Se2(0.1, 0.0, 0.2), 0.02));
  ekf->observe(2, {seen(0.9, -0.2, 1), seen(2.0, -1.3, 3)});
  const SlamState<Planar> before = ekf->snapshot();
  ASSERT_EQ(ekf->observe(3, {seen(-3.0, -3.0, 2)}).assignments[0].verdict, Verdict::kCreated);
  const SlamState<Planar> after = ekf->snapshot();

  std::vector<int> kept = {0, 1, 2, 3, 4, 7, 8};  // pose and the landmarks 1 and 3, which move up
  ASSERT_EQ(after.covariance.rows(), 9);
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) EXPECT_EQ(after.covariance(i, j), before.covariance(kept[i], kept[j]));
  }
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map.segment<2>(0), before.landmarks_in_map.segment<2>(0), 0.0));
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map.segment<2>(2), before.landmarks_in_map.segment<2>(4), 0.0));
  EXPECT_EQ(after.infos[0].source_id, 1);
  EXPECT_EQ(after.infos[1].source_id, 3);
  EXPECT_EQ(after.infos[2].source_id, 2);
  EXPECT_TRUE(IsCovariance(after.covariance));
}

TEST(Singular, IsRefusedAndNothingChanges) {
  const Estimator ekf = make(textbook());
  ekf->observe(1, {seen(1.0, 0.0, 1), seen(2.0, 0.0, 2)});
  const SlamState<Planar> before = ekf->snapshot();
  Observation<Planar> broken = seen(1.0, 0.0, 1);
  broken.covariance = -1e3 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(ekf->observe(2, {broken}).assignments[0].verdict, Verdict::kSingular);
  broken.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  const UpdateReport report = ekf->observe(2, {broken});
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kSingular);
  EXPECT_EQ(report.dof, 0);
  const SlamState<Planar> after = ekf->snapshot();
  EXPECT_TRUE(MatrixNear(after.covariance, before.covariance, 0.0));
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map, before.landmarks_in_map, 0.0));
  EXPECT_EQ(after.infos[0].observations, 1U);
}

/// Each of the two is regular by itself, both together are not: two exact sightings of one and the same
/// point.
TEST(Singular, IsFoundInTheJointUpdateToo) {
  const Estimator ekf = make(textbook());
  ekf->observe(1, {seen(1.0, 0.0, 1, 1e-12), seen(1.0, 0.0, 2, 1e-12)});
  const SlamState<Planar> before = ekf->snapshot();
  ekf->predict(motion<Planar>(Se2(), 0.1));
  const SlamState<Planar> moved = ekf->snapshot();
  const UpdateReport report = ekf->observe(2, {seen(1.0, 0.0, 1, 1e-12), seen(1.0, 0.0, 2, 1e-12)});
  for (const Assignment& assignment : report.assignments) EXPECT_EQ(assignment.verdict, Verdict::kSingular);
  EXPECT_TRUE(MatrixNear(ekf->snapshot().covariance, moved.covariance, 0.0));
  EXPECT_TRUE(MatrixNear(ekf->snapshot().landmarks_in_map, before.landmarks_in_map, 0.0));
}

}  // namespace
}  // namespace kinect_ekf_slam
