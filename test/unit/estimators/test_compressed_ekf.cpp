#include "kinect_ekf_slam/estimators/compressed_ekf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::pose_at;
using testing::Scenario;
using testing::seen;
using testing::textbook;

EstimatorOptions small_region(double radius = 3.0) {
  EstimatorOptions options = textbook();
  options.active_radius = radius;
  options.active_hysteresis = 0.2;
  return options;
}

AssociationOptions nearest_neighbor() {
  AssociationOptions options;
  options.type = AssociationOptions::Type::kNearestNeighbor;
  return options;
}

constexpr int kBeacon = 3;

/// Far off, where no landmark is active.
template <class Space>
typename Space::Point beacon() {
  return 8.0 * Space::Point::Unit(0);
}

template <class Space>
RangeMeasurement<Space> range_of(const Scenario<Space>& scenario) {
  BeaconRange measured{kBeacon, 0.0, 0.04, {0.1, 0.2, 0.0}};
  measured.range =
      RangeMeasurement<Space>(measured, 0.0).expected_range(scenario.true_pose(), beacon<Space>());
  return {measured, 0.0};
}

template <class Space>
PositionMeasurement<Space> position_of(const Scenario<Space>& scenario) {
  GlobalPosition measured;
  measured.position_in_map = Space::to_3d(scenario.true_pose()).translation();
  measured.covariance.setIdentity();
  return PositionMeasurement<Space>(measured);
}

/// The EKF and the compressed EKF, told the same.
template <class Space>
struct Pair {
  Ekf<Space> full;
  CompressedEkf<Space> compressed;

  Pair(const EstimatorOptions& options, const AssociationOptions& association,
       const PoseEstimate<Space>& initial)
      : full(options, make_associator<Space>(association), initial),
        compressed(options, make_associator<Space>(association), initial) {}

  void predict(const MotionStep<Space>& step) {
    full.predict(step);
    compressed.predict(step);
  }
  /// False when they do not say the same of each observation.
  ::testing::AssertionResult observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) {
    const UpdateReport left = compressed.observe(stamp, observations);
    const UpdateReport right = full.observe(stamp, observations);
    for (std::size_t k = 0; k < observations.size(); ++k) {
      const Assignment& a = left.assignments[k];
      const Assignment& b = right.assignments[k];
      if (a.verdict != b.verdict || a.landmark != b.landmark) {
        return ::testing::AssertionFailure()
               << "at " << stamp << " sighting " << k << ": " << to_string(a.verdict) << " " << a.landmark
               << ", the EKF says " << to_string(b.verdict) << " " << b.landmark;
      }
    }
    return ::testing::AssertionSuccess();
  }
  /// Does the same to both, by number.
  void interfere(int what, const Scenario<Space>& scenario) {
    for (SlamEstimator<Space>* each :
         {static_cast<SlamEstimator<Space>*>(&full), static_cast<SlamEstimator<Space>*>(&compressed)}) {
      if (what == 0) each->set_pose(pose_at<Space>(scenario.true_pose(), 0.3));
      if (what == 1) each->set_map_fixed(true);
      if (what == 2) each->set_map_fixed(false);
      if (what == 3) each->restore(each->snapshot());
      if (what == 4) each->loosen(1e-3 * Space::PoseMatrix::Identity());
      if (what == 5) each->locate(range_of(scenario), beacon_landmark_id(kBeacon), 20.0);
      if (what == 6) each->locate(position_of(scenario), kNoId, 20.0);
    }
  }
};

/// Each number of the state within `tolerance` of the state's size, each of the covariance within
/// `tolerance` of the product of the two standard deviations.
template <class Space>
::testing::AssertionResult SameState(const SlamState<Space>& left, const SlamState<Space>& right,
                                     double tolerance) {
  if (left.infos.size() != right.infos.size()) {
    return ::testing::AssertionFailure() << left.infos.size() << " landmarks, not " << right.infos.size();
  }
  for (std::size_t i = 0; i < left.infos.size(); ++i) {
    if (left.infos[i].id != right.infos[i].id || left.infos[i].observations != right.infos[i].observations) {
      return ::testing::AssertionFailure() << "landmark " << i << " is another";
    }
  }
  const Eigen::VectorXd sigma = right.covariance.diagonal().cwiseSqrt();
  const double of_pose = pose_error<Space>(right.map_from_base, left.map_from_base).norm();
  const double of_landmarks = (left.landmarks_in_map - right.landmarks_in_map).norm();
  const double of_covariance =
      ((left.covariance - right.covariance).array() / (sigma * sigma.transpose()).array()).abs().maxCoeff();
  if (of_pose <= tolerance * right.map_from_base.translation().norm() &&
      of_landmarks <= tolerance * right.landmarks_in_map.norm() && of_covariance <= tolerance) {
    return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "pose differs by " << of_pose << ", landmarks by " << of_landmarks
                                       << ", covariance by " << of_covariance << " sigma^2";
}

template <class Space>
::testing::AssertionResult SameLandmarks(const std::vector<LandmarkEstimate<Space>>& left,
                                         const std::vector<LandmarkEstimate<Space>>& right,
                                         double tolerance) {
  if (left.size() != right.size()) return ::testing::AssertionFailure() << left.size() << " landmarks";
  for (std::size_t i = 0; i < left.size(); ++i) {
    const auto place = testing::MatrixNear(left[i].position_in_map, right[i].position_in_map, tolerance);
    const auto sure =
        testing::MatrixNear(left[i].covariance, right[i].covariance, tolerance * right[i].covariance.norm());
    if (!place || !sure || left[i].info.id != right[i].info.id) return place ? sure : place;
  }
  return ::testing::AssertionSuccess();
}

/// Straight on near the middle of the world, and back there from its border.
template <class Space>
typename Space::PoseVector wander(const Scenario<Space>& scenario) {
  typename Space::PoseVector twist = testing::gentle_curve<Space>();
  twist(0) = 0.1;
  const typename Space::Point home = scenario.true_pose().inverse() * Space::Point::Zero();
  constexpr double kFar = 3.5;  // m
  if (home.norm() < kFar) {
    twist(Space::kPoseDim - 1) = 0.01;
  } else {
    const typename Space::Point ahead = Space::Point::Unit(0);
    twist.template tail<Space::kTurnDim>() =
        0.15 / home.norm() * Space::by_turn(ahead).transpose() * home;  // the turn from ahead to home
  }
  return twist;
}

template <class SpaceType>
class CompressedEkfTest : public ::testing::Test {
 protected:
  using TestSpace = SpaceType;
  static PoseEstimate<SpaceType> start() { return pose_at<SpaceType>(typename SpaceType::Pose(), 0.01); }
};
using Spaces = ::testing::Types<Planar, Spatial>;
TYPED_TEST_SUITE(CompressedEkfTest, Spaces);

TYPED_TEST(CompressedEkfTest, IsTheEkfOverALongRunThroughManyRegions) {
  using Space = TypeParam;
  Scenario<Space> scenario(1, Space::kPointDim == 2 ? 40 : 60);
  scenario.range = 2.4;
  scenario.start_at(this->start());
  Pair<Space> pair(small_region(), testing::known_identities(), this->start());
  constexpr int kSteps = 10000;
  for (int i = 1; i <= kSteps; ++i) {
    pair.predict(scenario.drive(wander(scenario)));
    ASSERT_TRUE(pair.observe(i, scenario.look()));
    if (i % 500 == 0) {
      ASSERT_TRUE(SameState(pair.compressed.snapshot(), pair.full.snapshot(), 1e-9)) << "after " << i;
    }
  }
  EXPECT_GE(pair.compressed.region_changes(), 20);
}

/// Far from home all is uncertain, but together: what is beside the sensor's view stays passive.
TYPED_TEST(CompressedEkfTest, KeepsActiveOnlyWhatIsNear) {
  using Space = TypeParam;
  constexpr double kSensorReach = 2.0;  // m
  const auto initial = pose_at<Space>(typename Space::Pose(), 0.1);
  CompressedEkf<Space> filter(small_region(), make_associator<Space>(nearest_neighbor()), initial);
  typename Space::PoseVector half_a_meter = Space::PoseVector::Zero();
  half_a_meter(0) = 0.5;
  for (int i = 0; i < 100; ++i) {
    filter.predict(testing::motion<Space>(Space::Pose::exp(half_a_meter), 1e-3));
    std::vector<Observation<Space>> observations;
    const double robot = 0.5 * (i + 1);
    for (double x = std::ceil(robot - kSensorReach); x <= robot + kSensorReach; ++x) {
      typename Space::Point point = Space::Point::Unit(1);
      point(0) = x - robot;
      observations.push_back(seen<Space>(point, kNoId, 0.01));
    }
    filter.observe(i + 1, observations);
    EXPECT_LE(filter.active_landmarks(), 9);  // 3 m to each side, and 0.6 m on; two more for the gate
  }
  EXPECT_GE(filter.landmarks().size(), 50U);
  EXPECT_LE(filter.region_changes(), 60);
}

/// Sensor's reach, region and association at random; now and then somebody interferes.
TYPED_TEST(CompressedEkfTest, IsTheEkfWhateverHappens) {
  using Space = TypeParam;
  constexpr int kSeeds = 30;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    const auto one_in = [&](int count) { return std::uniform_int_distribution<>(1, count)(random) == count; };
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<>(low, high)(random);
    };
    Scenario<Space> scenario(seed, 30);
    scenario.range = between(1.5, 5.0);
    scenario.start_at(this->start());
    EstimatorOptions options = small_region(between(0.2, 4.0));
    options.active_hysteresis = between(0.0, 1.0);
    options.robust_threshold = one_in(2) ? 6.0 : 0.0;
    options.replace_after = one_in(2) ? 2 : 0;
    options.max_landmarks = one_in(3) ? 15 : 100;
    Pair<Space> pair(options, one_in(2) ? testing::known_identities(0.99) : nearest_neighbor(),
                     this->start());
    for (SlamEstimator<Space>* each : {static_cast<SlamEstimator<Space>*>(&pair.full),
                                       static_cast<SlamEstimator<Space>*>(&pair.compressed)}) {
      each->add_landmark(beacon_landmark_id(kBeacon), beacon<Space>(), Space::PointMatrix::Identity());
    }
    for (int i = 1; i <= 300; ++i) {
      pair.predict(scenario.drive(wander(scenario)));
      auto observations = scenario.look();
      if (one_in(5)) {  // an object where none was, or an identity misread
        observations.push_back(seen<Space>(between(0.5, 3.0) * Space::Point::Unit(0), i % 30));
      }
      ASSERT_TRUE(pair.observe(i, observations)) << "seed " << seed;
      pair.interfere(one_in(20) ? static_cast<int>(random() % 7) : -1, scenario);
      if (one_in(25)) {
        ASSERT_TRUE(SameState(pair.compressed.snapshot(), pair.full.snapshot(), 1e-8)) << "seed " << seed;
        ASSERT_TRUE(SameLandmarks(pair.compressed.landmarks(), pair.full.landmarks(), 1e-8))
            << "seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
