/// Local maps, the path in their state, and what can be done with whole states.
#include "kinect_ekf_slam/mapping/local_maps.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>
#include <stdexcept>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/estimators/pose_parts.h"
#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "kinect_ekf_slam/mapping/state_algebra.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::PoseNear;
using testing::Scenario;

template <class Space>
class LocalMapsIn : public ::testing::Test {
 protected:
  static constexpr int kPoint = Space::kPointDim;
  using Pose = typename Space::Pose;

  static std::unique_ptr<LocalMaps<Space>> make(
      const LocalMapOptions& options, AssociationOptions association = testing::known_identities()) {
    return make_local_maps<Space>(testing::textbook(), association, {}, options,
                                  testing::pose_at<Space>(Pose(), 1e-4));
  }
  /// A run of `steps` seconds through landmarks all round, with a gap in which none is seen.
  static void run(Scenario<Space>* scenario, int steps, int gap_start, int gap_end, LocalMaps<Space>* maps,
                  std::vector<Pose>* truth) {
    typename Space::PoseVector twist = Space::PoseVector::Zero();
    twist(0) = 0.2;
    twist.template tail<1>()(0) = 0.15;
    maps->observe(0, scenario->look());
    truth->push_back(scenario->true_pose());
    for (int step = 1; step <= steps; ++step) {
      maps->predict(scenario->drive(twist));
      auto seen = scenario->look();
      if (step >= gap_start && step < gap_end) seen.clear();
      maps->observe(to_nanoseconds(step), seen);
      truth->push_back(scenario->true_pose());
    }
  }
  static typename Space::Point point(const SlamState<Space>& state, std::size_t i) {
    return state.landmarks_in_map.template segment<kPoint>(kPoint * static_cast<Eigen::Index>(i));
  }
};
TYPED_TEST_SUITE(LocalMapsIn, testing::Spaces, testing::SpaceNames);

TYPED_TEST(LocalMapsIn, StartAnewWhenNothingIsMatchedForAWhile) {
  using Space = TypeParam;
  Scenario<Space> scenario(1, 30);
  LocalMapOptions options;
  options.gap_time = 3.0;
  options.max_position_sigma = 1e3;
  options.max_turn_sigma_deg = 1e3;
  const auto maps = TestFixture::make(options);
  std::vector<typename Space::Pose> truth;
  TestFixture::run(&scenario, 40, 20, 30, maps.get(), &truth);
  const auto all = maps->maps();
  ASSERT_EQ(all.size(),
            2U);  // the second one was started in the gap and is not over for having seen nothing yet
  EXPECT_EQ(all[0].start, 0);
  EXPECT_EQ(all[0].end, to_nanoseconds(23.0));
  EXPECT_EQ(all[1].start, all[0].end);
  EXPECT_EQ(all[1].end, to_nanoseconds(40.0));
  for (const LocalMap<Space>& map : all) {
    EXPECT_EQ(map.path_points().size(), map.path_stamps.size());
    EXPECT_EQ(map.path_stamps.front(), map.start);
    EXPECT_EQ(map.path_stamps.back(), map.end);
    EXPECT_TRUE(IsCovariance(map.state.covariance, 1e-9));
  }
  EXPECT_TRUE(PoseNear(maps->pose().map_from_base, truth.back(), 1.0));
  for (const auto& landmark : maps->landmarks()) EXPECT_FALSE(is_path_point(landmark.info));
}

TYPED_TEST(LocalMapsIn, StartAnewWhenThePoseIsTooUncertainOrThePathTooLong) {
  using Space = TypeParam;
  LocalMapOptions options;
  options.max_position_sigma = 0.06;
  const auto uncertain = TestFixture::make(options);
  Scenario<Space> blind(2, 0);
  std::vector<typename Space::Pose> truth;
  TestFixture::run(&blind, 40, 0, 0, uncertain.get(), &truth);
  EXPECT_GT(uncertain->maps().size(), 2U);

  options.max_position_sigma = 1e3;
  options.max_turn_sigma_deg = 1e3;
  options.max_path_points = 15;
  const auto full = TestFixture::make(options);
  Scenario<Space> other(2, 0);
  TestFixture::run(&other, 40, 0, 0, full.get(), &truth);
  EXPECT_EQ(full->maps().size(), 3U);
}

/// A camera that says nothing is no reason to lose the way, or to forget landmarks that it does not look at.
TYPED_TEST(LocalMapsIn, GoOnWhereNobodyLooks) {
  using Space = TypeParam;
  LocalMapOptions options;
  options.gap_time = 5.0;
  options.max_position_sigma = options.max_turn_sigma_deg = 1e3;
  const auto maps = TestFixture::make(options);
  Scenario<Space> scenario(1, 30);
  std::vector<typename Space::Pose> truth;
  TestFixture::run(&scenario, 10, 0, 0, maps.get(), &truth);
  const std::size_t landmarks = maps->landmarks().size();
  typename Space::PoseVector twist = Space::PoseVector::Zero();
  twist(0) = 0.2;
  for (int second = 11; second <= 14; ++second) {
    maps->predict(scenario.drive(twist));
    maps->go_on(to_nanoseconds(second));
  }
  ASSERT_EQ(maps->maps().size(), 1U);
  EXPECT_EQ(maps->maps()[0].end, to_nanoseconds(14.0));
  EXPECT_EQ(maps->maps()[0].path_stamps.size(), 15U);
  EXPECT_EQ(maps->landmarks().size(), landmarks);
  for (int second = 15; second <= 16; ++second) maps->go_on(to_nanoseconds(second));
  ASSERT_EQ(maps->maps().size(), 1U) << "closed at 16 s, and nothing of the next one yet";
  EXPECT_EQ(maps->maps()[0].end, to_nanoseconds(16.0));
  maps->go_on(to_nanoseconds(17.0));
  EXPECT_EQ(maps->maps().size(), 2U);
}

/// The path points do not change what the filter says, and association does not see them.
TYPED_TEST(LocalMapsIn, WithOneMapIsThePlainFilter) {
  using Space = TypeParam;
  for (const auto type :
       {AssociationOptions::Type::kNearestNeighbor, AssociationOptions::Type::kJointCompatibility}) {
    AssociationOptions association = testing::known_identities();
    association.type = type;
    association.new_landmark_probability = 1.0 - 1e-9;
    LocalMapOptions options;
    options.max_position_sigma = options.max_turn_sigma_deg = options.gap_time = 1e9;
    const auto maps = TestFixture::make(options, association);
    const auto plain = make_slam<Space>(testing::textbook(), association, {},
                                        testing::pose_at<Space>(typename Space::Pose(), 1e-6));
    Scenario<Space> scenario(3, 20);
    typename Space::PoseVector twist = Space::PoseVector::Zero();
    twist(0) = 0.2;
    for (int step = 1; step <= 30; ++step) {
      const auto motion = scenario.drive(twist);
      const auto seen = scenario.look();
      maps->predict(motion);
      plain->predict(motion);
      maps->observe(to_nanoseconds(step), seen);
      plain->observe(to_nanoseconds(step), seen);
    }
    EXPECT_TRUE(PoseNear(maps->pose().map_from_base, plain->pose().map_from_base, 1e-5));
    EXPECT_EQ(maps->landmarks().size(), plain->landmarks().size());
  }
}

/// Pose, landmarks and path, all together: NEES over many runs. The path is the smoothed one.
TYPED_TEST(LocalMapsIn, KnowTheJointErrorsOfPathAndLandmarks) {
  using Space = TypeParam;
  constexpr int kRuns = 60;
  double nees = 0.0;
  double dof = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Scenario<Space> scenario(100 + run, 6, 3.0);
    scenario.sensor_sigma = 0.03;
    scenario.motion_sigma = 0.005;
    LocalMapOptions options;
    options.max_position_sigma = options.max_turn_sigma_deg = options.gap_time = 1e9;
    options.path_interval = 4.0;
    const auto maps = TestFixture::make(options);
    std::vector<typename Space::Pose> truth;
    TestFixture::run(&scenario, 20, 0, 0, maps.get(), &truth);
    const LocalMap<Space> map = maps->maps().front();
    Eigen::VectorXd error(map.state.covariance.rows());
    error.template head<Space::kPoseDim>() = pose_error<Space>(map.state.map_from_base, truth.back());
    std::size_t path_point = 0;
    for (std::size_t i = 0; i < map.state.infos.size(); ++i) {
      const LandmarkInfo& info = map.state.infos[i];
      const auto time = is_path_point(info) ? map.path_stamps[path_point++] : 0;
      const typename Space::Point true_point =
          is_path_point(info) ? truth[static_cast<std::size_t>(to_seconds(time))].translation()
                              : scenario.landmarks()[static_cast<std::size_t>(info.source_id)];
      error.template segment<Space::kPointDim>(Space::kPoseDim + Space::kPointDim * static_cast<int>(i)) =
          true_point - TestFixture::point(map.state, i);
    }
    // The last path point is where the robot is, and the first one the frame's origin: they say nothing of
    // their own.
    std::vector<int> telling;
    const auto path = map.path_points();
    for (int i = 0; i < static_cast<int>(map.state.infos.size()); ++i) {
      if (i != path.front() && i != path.back()) telling.push_back(i);
    }
    const SlamState<Space> chosen = with_points<Space>(map.state, telling);
    Eigen::VectorXd chosen_error(chosen.covariance.rows());
    chosen_error.template head<Space::kPoseDim>() = error.template head<Space::kPoseDim>();
    for (std::size_t k = 0; k < telling.size(); ++k) {
      chosen_error.template segment<Space::kPointDim>(Space::kPoseDim +
                                                      Space::kPointDim * static_cast<int>(k)) =
          error.template segment<Space::kPointDim>(Space::kPoseDim + Space::kPointDim * telling[k]);
    }
    nees += chosen_error.dot(chosen.covariance.ldlt().solve(chosen_error));
    dof += static_cast<double>(chosen_error.size());
  }
  EXPECT_GT(nees, chi_square_quantile(0.0005, dof));
  EXPECT_LT(nees, chi_square_quantile(0.9995, dof));
}

TYPED_TEST(LocalMapsIn, RefuseWhatIsNoKalmanFilter) {
  EstimatorOptions particles = testing::textbook(EstimatorOptions::Type::kFastSlam1);
  EXPECT_THROW(make_local_maps<TypeParam>(particles, testing::known_identities(), {}, {}, {}),
               std::invalid_argument);
  AssociationOptions several;
  several.type = AssociationOptions::Type::kMultiHypothesis;
  EXPECT_THROW(make_local_maps<TypeParam>(testing::textbook(), several, {}, {}, {}), std::invalid_argument);
}

template <class Space>
SlamState<Space> random_state(int points, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(random); };
  SlamState<Space> state;
  state.map_from_base = Space::Pose::exp(Space::PoseVector::NullaryExpr(draw));
  state.landmarks_in_map = Eigen::VectorXd::NullaryExpr(Space::kPointDim * points, draw);
  state.infos.resize(static_cast<std::size_t>(points));
  const Eigen::Index size = Space::kPoseDim + state.landmarks_in_map.size();
  const Eigen::MatrixXd A = 1e-3 * Eigen::MatrixXd::NullaryExpr(size, size, draw);
  state.covariance = A * A.transpose();
  state.covariance = Eigen::MatrixXd(state.covariance.template selfadjointView<Eigen::Lower>());
  return state;
}

/// A state as its error moves it.
template <class Space>
SlamState<Space> moved(SlamState<Space> state, const Eigen::VectorXd& error) {
  state.map_from_base = moved_by_error<Space>(state.map_from_base, error.template head<Space::kPoseDim>());
  state.landmarks_in_map += error.tail(state.landmarks_in_map.size());
  return state;
}

/// What leads from one state to another, as the covariance counts it.
template <class Space>
Eigen::VectorXd difference(const SlamState<Space>& from, const SlamState<Space>& to) {
  Eigen::VectorXd error(from.covariance.rows());
  error << pose_error<Space>(from.map_from_base, to.map_from_base),
      to.landmarks_in_map - from.landmarks_in_map;
  return error;
}

template <class Space>
class StateAlgebra : public ::testing::Test {};
TYPED_TEST_SUITE(StateAlgebra, testing::Spaces, testing::SpaceNames);

TYPED_TEST(StateAlgebra, JoinsWithTheNumericalJacobian) {
  using Space = TypeParam;
  const auto first = random_state<Space>(2, 1);
  const auto second = random_state<Space>(3, 2);
  const auto joined = joined_states<Space>(first, second);
  const Eigen::Index size = first.covariance.rows();
  const auto join = [&](const Eigen::VectorXd& error) {
    return difference<Space>(
        joined, joined_states<Space>(moved<Space>(first, error.head(size)),
                                     moved<Space>(second, error.tail(second.covariance.rows()))));
  };
  const Eigen::MatrixXd J =
      testing::numerical_jacobian(join, Eigen::VectorXd::Zero(size + second.covariance.rows()));
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  both.topLeftCorner(size, size) = first.covariance;
  both.bottomRightCorner(J.cols() - size, J.cols() - size) = second.covariance;
  EXPECT_TRUE(MatrixNear(joined.covariance, J * both * J.transpose(), 1e-8));
  EXPECT_TRUE(PoseNear(joined.map_from_base, first.map_from_base * second.map_from_base, 1e-12));
}

TYPED_TEST(StateAlgebra, MovesPointsWithTheNumericalJacobian) {
  using Space = TypeParam;
  const auto state = random_state<Space>(3, 3);
  const auto result = moved_by_pose<Space>(state);
  const auto move = [&](const Eigen::VectorXd& error) {
    return difference<Space>(result, moved_by_pose<Space>(moved<Space>(state, error)));
  };
  const Eigen::MatrixXd J = testing::numerical_jacobian(move, Eigen::VectorXd::Zero(state.covariance.rows()));
  EXPECT_TRUE(MatrixNear(result.covariance, J * state.covariance * J.transpose(), 1e-8));
}

/// Against the Kalman update with full matrices; and refused outside of the gate.
TYPED_TEST(StateAlgebra, MergesAsTheKalmanUpdateByTheirDifference) {
  using Space = TypeParam;
  constexpr int kPoint = Space::kPointDim;
  auto state = random_state<Space>(3, 4);
  state.landmarks_in_map.template segment<kPoint>(2 * kPoint) =
      state.landmarks_in_map.template head<kPoint>().array() + 1e-3;
  const auto prior = state;
  EXPECT_FALSE(merge_points<Space>(0, 1, 9.0, &state));
  EXPECT_TRUE(MatrixNear(state.covariance, prior.covariance, 0.0));
  ASSERT_TRUE(merge_points<Space>(0, 2, 100.0, &state));
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kPoint, prior.covariance.rows());
  H.block(0, Space::kPoseDim, kPoint, kPoint).setIdentity();
  H.block(0, Space::kPoseDim + 2 * kPoint, kPoint, kPoint) = -Eigen::MatrixXd::Identity(kPoint, kPoint);
  const Eigen::MatrixXd S =
      H * prior.covariance * H.transpose() + 1e-6 * Eigen::MatrixXd::Identity(kPoint, kPoint);
  const Eigen::MatrixXd K = prior.covariance * H.transpose() * S.inverse();
  EXPECT_TRUE(MatrixNear(state.covariance, prior.covariance - K * S * K.transpose(), 1e-12));
  const Eigen::VectorXd error = K * Eigen::VectorXd::Constant(kPoint, 1e-3);
  EXPECT_TRUE(MatrixNear(difference<Space>(prior, state), error, 1e-9));
}

TYPED_TEST(StateAlgebra, KeepsTheChosenPointsInTheirOrder) {
  using Space = TypeParam;
  constexpr int kPoint = Space::kPointDim;
  constexpr int kPose = Space::kPoseDim;
  const auto state = random_state<Space>(3, 5);
  const auto chosen = with_points<Space>(state, {2, 0});
  EXPECT_TRUE(MatrixNear(chosen.landmarks_in_map.head(kPoint), state.landmarks_in_map.tail(kPoint), 0.0));
  EXPECT_TRUE(MatrixNear(chosen.covariance.block(kPose, kPose + kPoint, kPoint, kPoint),
                         state.covariance.block(kPose + 2 * kPoint, kPose, kPoint, kPoint), 0.0));
  EXPECT_TRUE(MatrixNear(chosen.covariance.block(0, kPose, kPose, kPoint),
                         state.covariance.block(0, kPose + 2 * kPoint, kPose, kPoint), 0.0));
}

}  // namespace
}  // namespace kinect_ekf_slam
