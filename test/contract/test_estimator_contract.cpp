/// What every estimator does, in every space. A new estimator adds a line to the list of cases.
#include <gtest/gtest.h>

#include <algorithm>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::motion;
using testing::pose_at;
using testing::Scenario;
using testing::seen;

template <class SpaceType, EstimatorOptions::Type kTypeValue>
struct Case {
  using Space = SpaceType;
  static constexpr EstimatorOptions::Type kType = kTypeValue;
  /// To what the estimate is exact where only rounding should differ. Sigma points feel the second order of
  /// the errors, and lie along the axes: a fraction of a standard deviation, not of rounding.
  static constexpr double kExactness = kType == EstimatorOptions::Type::kUkf ? 1e-3 : 1e-9;
  /// Particles hold a Gaussian as samples: what another says exactly holds for them on the average.
  static constexpr bool kSamples =
      kType == EstimatorOptions::Type::kFastSlam1 || kType == EstimatorOptions::Type::kFastSlam2;
  /// A covariance that goes through the robot's axes and back.
  static constexpr double kRounding = kSamples ? 1e-15 : 0.0;
  /// m; a mean over 100 particles of what is known to 0.01 m at 2 m and 0.01 rad, five times its deviation.
  static constexpr double kPlacing = kSamples ? 0.012 : 1e-12;
  /// Two estimators in the same state go on with the same bits, but not where one has work put off.
  static constexpr double kDeferred = kType == EstimatorOptions::Type::kCompressedEkf ? 1e-9 : 0.0;
};

using Type = EstimatorOptions::Type;
template <Type kType>
using Plane = Case<Planar, kType>;
template <Type kType>
using Space3d = Case<Spatial, kType>;
using Cases = ::testing::Types<Plane<Type::kEkf>, Plane<Type::kInvariantEkf>, Plane<Type::kCompressedEkf>,
                               Plane<Type::kUkf>, Plane<Type::kFastSlam1>, Plane<Type::kFastSlam2>,
                               Plane<Type::kDeadReckoning>, Space3d<Type::kEkf>, Space3d<Type::kInvariantEkf>,
                               Space3d<Type::kCompressedEkf>, Space3d<Type::kUkf>, Space3d<Type::kFastSlam1>,
                               Space3d<Type::kFastSlam2>, Space3d<Type::kDeadReckoning>>;

template <class EstimatorCase>
class EstimatorContract : public ::testing::Test {
 protected:
  using CaseSpace = typename EstimatorCase::Space;
  using Pose = typename CaseSpace::Pose;
  using Point = typename CaseSpace::Point;
  using Estimator = std::unique_ptr<SlamEstimator<CaseSpace>>;

  static EstimatorOptions options() {
    EstimatorOptions options = testing::textbook(EstimatorCase::kType);
    options.active_radius = 2.0;  // half as far as the sensor sees: the active region changes often
    return options;
  }

  static Estimator make(const PoseEstimate<CaseSpace>& initial = start(),
                        const EstimatorOptions& used = options(),
                        const AssociationOptions& association = testing::known_identities()) {
    return make_estimator<CaseSpace>(used, association, initial);
  }
  static PoseEstimate<CaseSpace> start() { return pose_at<CaseSpace>(Pose::exp(some_twist()), 0.01); }

  static typename CaseSpace::PoseVector some_twist(double scale = 1.0) {
    typename CaseSpace::PoseVector twist;
    for (int i = 0; i < CaseSpace::kPoseDim; ++i) twist(i) = scale * (0.5 - 0.3 * i);
    return twist;
  }
  static Point point(double ahead, double aside) {
    Point point = Point::Zero();
    point(0) = ahead;
    point(1) = aside;
    return point;
  }
  static ::testing::AssertionResult SamePose(const Pose& left, const Pose& right, double tolerance) {
    return MatrixNear(CaseSpace::to_3d(left).matrix(), CaseSpace::to_3d(right).matrix(), tolerance);
  }

  /// Drives and looks; returns the reports.
  static std::vector<UpdateReport> run(SlamEstimator<CaseSpace>* estimator, Scenario<CaseSpace>* scenario,
                                       int steps, TimeNs first = 1) {
    std::vector<UpdateReport> reports;
    for (int i = 0; i < steps; ++i) {
      estimator->predict(scenario->drive(testing::gentle_curve<CaseSpace>()));
      reports.push_back(estimator->observe(first + i, scenario->look()));
    }
    return reports;
  }
  static Estimator made_a_map(std::uint64_t seed = 1) {
    Scenario<CaseSpace> scenario(seed, 8);
    Estimator estimator = make();
    scenario.start_at(start());
    run(estimator.get(), &scenario, 20);
    return estimator;
  }
  /// Equal, to the last bit when nothing else is said.
  static void expect_same(const SlamEstimator<CaseSpace>& left, const SlamEstimator<CaseSpace>& right,
                          double tolerance = 0.0) {
    const SlamState<CaseSpace> a = left.snapshot();
    const SlamState<CaseSpace> b = right.snapshot();
    EXPECT_TRUE(SamePose(a.map_from_base, b.map_from_base, tolerance));
    EXPECT_TRUE(MatrixNear(a.landmarks_in_map, b.landmarks_in_map, tolerance));
    EXPECT_TRUE(MatrixNear(a.covariance, b.covariance, tolerance));
    ASSERT_EQ(a.infos.size(), b.infos.size());
    for (std::size_t i = 0; i < a.infos.size(); ++i) {
      EXPECT_EQ(a.infos[i].id, b.infos[i].id);
      EXPECT_EQ(a.infos[i].source_id, b.infos[i].source_id);
      EXPECT_EQ(a.infos[i].observations, b.infos[i].observations);
    }
  }
  /// Equal to the last bit; of particles: the same pose, landmarks and covariances of each.
  static void expect_equivalent(const SlamEstimator<CaseSpace>& left, const SlamEstimator<CaseSpace>& right) {
    if (!EstimatorCase::kSamples) return expect_same(left, right);
    EXPECT_TRUE(SamePose(left.pose().map_from_base, right.pose().map_from_base, 1e-9));
    EXPECT_TRUE(MatrixNear(left.pose().covariance, right.pose().covariance, 1e-9));
    const auto a = left.landmarks();
    const auto b = right.landmarks();
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].info.id, b[i].info.id);
      EXPECT_EQ(a[i].info.observations, b[i].info.observations);
      EXPECT_TRUE(MatrixNear(a[i].position_in_map, b[i].position_in_map, 1e-9));
      EXPECT_TRUE(MatrixNear(a[i].covariance, b[i].covariance, 1e-9));
    }
  }
};

TYPED_TEST_SUITE(EstimatorContract, Cases);

TYPED_TEST(EstimatorContract, StartsWhereItIsToldWithAnEmptyMap) {
  const auto estimator = this->make();
  EXPECT_TRUE(this->SamePose(estimator->pose().map_from_base, this->start().map_from_base, 0.0));
  EXPECT_TRUE(MatrixNear(estimator->pose().covariance, this->start().covariance, TypeParam::kRounding));
  EXPECT_TRUE(estimator->landmarks().empty());
  EXPECT_EQ(estimator->snapshot().covariance.rows(), TypeParam::Space::kPoseDim);
}

TYPED_TEST(EstimatorContract, MovesBeforeTheFirstLandmark) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make();
  const auto delta = Space::Pose::exp(this->some_twist(0.5));
  estimator->predict(motion<Space>(delta, 0.02));
  EXPECT_TRUE(this->SamePose(estimator->pose().map_from_base, this->start().map_from_base * delta,
                             TypeParam::kExactness));
  EXPECT_GT(estimator->pose().covariance.trace(), this->start().covariance.trace());
  EXPECT_TRUE(IsCovariance(estimator->pose().covariance));
}

TYPED_TEST(EstimatorContract, PutsANewLandmarkWhereItIsSeen) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make();
  auto sighting = seen<Space>(this->point(2.0, -1.0), 7);
  sighting.signature.label = "red";
  const UpdateReport report = estimator->observe(5, {sighting});
  ASSERT_EQ(report.assignments.size(), 1U);
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kCreated);
  const auto landmarks = estimator->landmarks();
  ASSERT_EQ(landmarks.size(), 1U);
  EXPECT_EQ(landmarks[0].info.id, report.assignments[0].landmark);
  EXPECT_EQ(landmarks[0].info.source_id, 7);
  EXPECT_EQ(landmarks[0].info.label(), "red");
  EXPECT_EQ(landmarks[0].info.last_seen, 5);
  EXPECT_TRUE(MatrixNear(landmarks[0].position_in_map, this->start().map_from_base * this->point(2.0, -1.0),
                         TypeParam::kPlacing));
  EXPECT_TRUE(IsCovariance(landmarks[0].covariance));
}

TYPED_TEST(EstimatorContract, FindsALandmarkAgainByItsIdentity) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make();
  const int first = estimator->observe(1, {seen<Space>(this->point(2.0, 0.0), 7)}).assignments[0].landmark;
  estimator->observe(2, {seen<Space>(this->point(1.0, 1.0), 3)});
  const UpdateReport report = estimator->observe(3, {seen<Space>(this->point(2.02, 0.01), 7)});
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kMatched);
  EXPECT_EQ(report.assignments[0].landmark, first);
  ASSERT_EQ(estimator->landmarks().size(), 2U);
  EXPECT_EQ(estimator->landmarks()[0].info.observations, 2U);
  EXPECT_EQ(estimator->landmarks()[1].info.observations, 1U);
}

TYPED_TEST(EstimatorContract, SeeingNothingChangesNothing) {
  const auto estimator = this->made_a_map();
  const auto before = estimator->clone();
  const UpdateReport report = estimator->observe(100, {});
  EXPECT_TRUE(report.assignments.empty());
  EXPECT_EQ(report.dof, 0);
  this->expect_same(*estimator, *before);
}

TYPED_TEST(EstimatorContract, TakesOneOfTwoSightingsWithTheSameIdentity) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make();
  for (int i = 0; i < 2; ++i) {  // at first of an unknown landmark, then of a known one
    const UpdateReport report = estimator->observe(
        1 + i, {seen<Space>(this->point(2.1, 0.0), 7), seen<Space>(this->point(2.0, 0.0), 7)});
    EXPECT_EQ(report.assignments[0].verdict, Verdict::kDuplicateIdentity);
    EXPECT_TRUE(is_accepted(report.assignments[1].verdict));
    ASSERT_EQ(estimator->landmarks().size(), 1U);
    EXPECT_EQ(estimator->landmarks()[0].info.observations, 1U + i);
  }
}

TYPED_TEST(EstimatorContract, TakesOneOfTwoSightingsThatBothContradictTheMap) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->make();
  estimator->observe(1, {seen<Space>(this->point(2.0, 0.0), 7)});
  const UpdateReport report =
      estimator->observe(2, {seen<Space>(this->point(-3.0, 0.0), 7), seen<Space>(this->point(0.0, 4.0), 7)});
  EXPECT_LE(is_accepted(report.assignments[0].verdict) + is_accepted(report.assignments[1].verdict), 1);
}

TYPED_TEST(EstimatorContract, RefusesMoreLandmarksThanAllowed) {
  using Space = typename TypeParam::Space;
  EstimatorOptions options = this->options();
  options.max_landmarks = 2;
  const auto estimator = this->make(this->start(), options);
  const UpdateReport report =
      estimator->observe(1, {seen<Space>(this->point(1.0, 0.0), 1), seen<Space>(this->point(2.0, 0.0), 2),
                             seen<Space>(this->point(3.0, 0.0), 3)});
  EXPECT_EQ(report.assignments[1].verdict, Verdict::kCreated);
  EXPECT_EQ(report.assignments[2].verdict, Verdict::kMapFull);
  EXPECT_EQ(estimator->landmarks().size(), 2U);
  EXPECT_EQ(estimator->observe(2, {seen<Space>(this->point(2.0, 0.0), 2)}).assignments[0].verdict,
            Verdict::kMatched);
}

TYPED_TEST(EstimatorContract, AFixedMapStaysTheSameToTheLastBit) {
  using Space = typename TypeParam::Space;
  Scenario<Space> scenario(4, 8);
  const auto estimator = this->make();
  scenario.start_at(this->start());
  this->run(estimator.get(), &scenario, 20);
  estimator->set_map_fixed(true);
  const auto before = estimator->landmarks();
  this->run(estimator.get(), &scenario, 50, 100);
  const UpdateReport report = estimator->observe(200, {seen<Space>(this->point(1.0, 0.0), 4711)});
  EXPECT_EQ(report.assignments[0].verdict, Verdict::kNotInMap);

  const auto after = estimator->landmarks();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_TRUE(MatrixNear(after[i].position_in_map, before[i].position_in_map, 0.0));
    EXPECT_TRUE(MatrixNear(after[i].covariance, before[i].covariance, 0.0));
    EXPECT_EQ(after[i].info.observations, before[i].info.observations);
  }
}

TYPED_TEST(EstimatorContract, SnapshotAndRestoreChangeNothing) {
  const auto estimator = this->made_a_map();
  const auto before = estimator->clone();
  estimator->restore(estimator->snapshot());
  this->expect_equivalent(*estimator, *before);
}

TYPED_TEST(EstimatorContract, AnotherEstimatorGoesOnFromASnapshot) {
  using Space = typename TypeParam::Space;
  Scenario<Space> scenario(5, 8);
  const auto original = this->make();
  scenario.start_at(this->start());
  this->run(original.get(), &scenario, 20);
  const auto other = this->make(pose_at<Space>(typename Space::Pose(), 1.0));
  other->restore(original->snapshot());
  Scenario<Space> same_future = scenario;
  this->run(original.get(), &scenario, 20, 100);
  this->run(other.get(), &same_future, 20, 100);
  if (TypeParam::kSamples) {
    const auto error = scenario.error_of(other->pose().map_from_base);
    EXPECT_LT(error.template head<Space::kPointDim>().norm(), 0.3) << "m, after 8 m of driving";
    EXPECT_EQ(other->landmarks().size(), original->landmarks().size());
  } else {
    this->expect_same(*other, *original, TypeParam::kDeferred);
  }
}

TYPED_TEST(EstimatorContract, ACopyLivesOnItsOwn) {
  using Space = typename TypeParam::Space;
  const auto estimator = this->made_a_map();
  const auto before = estimator->snapshot();
  const auto copy = estimator->clone();
  copy->predict(motion<Space>(Space::Pose::exp(this->some_twist()), 0.1));
  copy->observe(100, {seen<Space>(this->point(1.0, 1.0), 999)});
  EXPECT_TRUE(MatrixNear(estimator->snapshot().covariance, before.covariance, 0.0));
  EXPECT_EQ(copy->landmarks().size(), estimator->landmarks().size() + 1);
}

TYPED_TEST(EstimatorContract, APoseThatIsSetIsIndependentOfTheMap) {
  using Space = typename TypeParam::Space;
  constexpr int kPoseDim = Space::kPoseDim;
  const auto estimator = this->made_a_map();
  const SlamState<Space> before = estimator->snapshot();
  const PoseEstimate<Space> put = pose_at<Space>(Space::Pose::exp(this->some_twist(-0.7)), 0.3);
  estimator->set_pose(put);
  EXPECT_TRUE(this->SamePose(estimator->pose().map_from_base, put.map_from_base, 0.0));
  EXPECT_TRUE(MatrixNear(estimator->pose().covariance, put.covariance, TypeParam::kRounding));
  const SlamState<Space> after = estimator->snapshot();
  const auto points = after.landmarks_in_map.size();
  EXPECT_TRUE(after.covariance.bottomLeftCorner(points, kPoseDim).isZero(0.0));
  EXPECT_TRUE(after.covariance.topRightCorner(kPoseDim, points).isZero(0.0));
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map, before.landmarks_in_map, 0.0));
  EXPECT_TRUE(MatrixNear(after.covariance.bottomRightCorner(points, points),
                         before.covariance.bottomRightCorner(points, points), 0.0));
}

TYPED_TEST(EstimatorContract, TheSameInputGivesTheSameBits) {
  this->expect_same(*this->made_a_map(3), *this->made_a_map(3));
}

TYPED_TEST(EstimatorContract, TheOrderOfTheSightingsDoesNotMatter) {
  using Space = typename TypeParam::Space;
  Scenario<Space> scenario(6, 8);
  const auto forward = this->make();
  scenario.start_at(this->start());
  this->run(forward.get(), &scenario, 20);  // the landmarks keep the order of the map
  const auto backward = forward->clone();
  for (int i = 0; i < 20; ++i) {
    const auto step = scenario.drive(testing::gentle_curve<Space>());
    auto observations = scenario.look();
    forward->predict(step);
    backward->predict(step);
    forward->observe(100 + i, observations);
    std::reverse(observations.begin(), observations.end());
    backward->observe(100 + i, observations);
  }
  const SlamState<Space> a = forward->snapshot();
  const SlamState<Space> b = backward->snapshot();
  EXPECT_TRUE(this->SamePose(a.map_from_base, b.map_from_base, 1e-9));
  ASSERT_EQ(a.landmarks_in_map.size(), b.landmarks_in_map.size());
  for (const auto& left : forward->landmarks()) {
    for (const auto& right : backward->landmarks()) {
      if (left.info.source_id != right.info.source_id) continue;
      EXPECT_TRUE(MatrixNear(left.position_in_map, right.position_in_map, 1e-9));
      EXPECT_TRUE(MatrixNear(left.covariance, right.covariance, 1e-9));
    }
  }
}

/// The map's frame is a matter of taste: a start elsewhere moves pose, map and covariance, and nothing else.
TYPED_TEST(EstimatorContract, AnotherMapFrameMovesTheEstimateWithIt) {
  using Space = typename TypeParam::Space;
  const auto other_from_map = Space::Pose::exp(this->some_twist(2.0));
  const PoseEstimate<Space> here = this->start();
  const auto rotation = error_from_local<Space>(other_from_map);
  typename Space::PoseMatrix turned = rotation * here.covariance * rotation.transpose();
  const auto original = this->make(here);
  const auto moved = this->make({other_from_map * here.map_from_base, turned});
  Scenario<Space> scenario(7, 8);
  scenario.start_at(here);
  Scenario<Space> same = scenario;
  this->run(original.get(), &scenario, 40);
  this->run(moved.get(), &same, 40);

  EXPECT_TRUE(this->SamePose(moved->pose().map_from_base, other_from_map * original->pose().map_from_base,
                             TypeParam::kExactness));
  const auto landmarks = original->landmarks();
  const auto moved_landmarks = moved->landmarks();
  ASSERT_EQ(moved_landmarks.size(), landmarks.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto R = other_from_map.rotation();
    EXPECT_TRUE(MatrixNear(moved_landmarks[i].position_in_map, other_from_map * landmarks[i].position_in_map,
                           TypeParam::kExactness));
    EXPECT_TRUE(MatrixNear(moved_landmarks[i].covariance, R * landmarks[i].covariance * R.transpose(),
                           TypeParam::kExactness));
  }
}

TYPED_TEST(EstimatorContract, CovariancesStayCovariances) {
  using Space = typename TypeParam::Space;
  Scenario<Space> scenario(8, 10);
  const auto estimator = this->make();
  scenario.start_at(this->start());
  for (int i = 0; i < 20; ++i) {
    this->run(estimator.get(), &scenario, 20, 1 + 20 * i);
    EXPECT_TRUE(IsCovariance(estimator->snapshot().covariance));
    EXPECT_TRUE(IsCovariance(estimator->pose().covariance));
    for (const auto& landmark : estimator->landmarks()) EXPECT_TRUE(IsCovariance(landmark.covariance));
  }
}

TYPED_TEST(EstimatorContract, FindsLandmarksAgainAtAnyBearing) {
  using Space = typename TypeParam::Space;
  AssociationOptions association;
  association.type = AssociationOptions::Type::kNearestNeighbor;
  for (int bearing = 0; bearing < 360; bearing += 15) {
    const auto estimator = this->make(this->start(), this->options(), association);
    const double angle = radians(bearing);
    const auto landmark = this->point(2.0 * std::cos(angle), 2.0 * std::sin(angle));
    estimator->observe(1, {seen<Space>(landmark, kNoId)});
    for (int i = 0; i < 24; ++i) {  // the robot turns on the spot, once round
      typename Space::PoseVector turn = Space::PoseVector::Zero();
      turn(Space::kPoseDim - 1) = radians(15);
      estimator->predict(motion<Space>(Space::Pose::exp(turn), 1e-3));
      const auto from_robot =
          estimator->pose().map_from_base.inverse() * (this->start().map_from_base * landmark);
      const UpdateReport report = estimator->observe(2 + i, {seen<Space>(from_robot, kNoId)});
      EXPECT_EQ(report.assignments[0].verdict, Verdict::kMatched)
          << bearing << " deg, turned by " << 15 * (i + 1);
    }
    EXPECT_EQ(estimator->landmarks().size(), 1U) << bearing;
  }
}

/// A sensor far from the robot's centre that looks backwards and is mounted askew, with a noise that is worse
/// along its ray: its sightings, brought into the base, converge.
TYPED_TEST(EstimatorContract, ConvergesWithASensorOffTheCentreAndTurned) {
  using Space = typename TypeParam::Space;
  constexpr int kPointDim = Space::kPointDim;
  typename Space::PoseVector mounting = Space::PoseVector::Constant(0.3);
  mounting(0) = -2.0;
  mounting(Space::kPoseDim - 1) = 2.8;
  const auto base_from_sensor = Space::Pose::exp(mounting);
  std::vector<typename Space::Point> landmarks;  // in the map
  for (int i = 0; i < 4; ++i) landmarks.push_back(Space::Point::Constant(0.4 * i - 0.5));
  for (int i = 0; i < 4; ++i) landmarks[i](0) = -3.0 - 0.5 * (i % 2);

  auto truth = typename Space::Pose();
  const auto estimator = this->make(pose_at<Space>(truth, 1e-3));
  Scenario<Space> noise(3, 0);
  for (int i = 0; i < 400; ++i) {
    const auto step = motion<Space>(Space::Pose::exp(0.1 * testing::gentle_curve<Space>()), 1e-3);
    truth = truth * step.delta * Space::Pose::exp(noise.draw(step.covariance));
    estimator->predict(step);
    std::vector<Observation<Space>> observations;
    for (std::size_t k = 0; k < landmarks.size(); ++k) {
      auto observation = seen<Space>(Space::Point::Zero(), static_cast<int>(k), 0.02);
      typename Space::PointMatrix in_sensor = observation.covariance;
      in_sensor(0, 0) *= 4.0;
      const typename Space::Point point_in_sensor =
          (truth * base_from_sensor).inverse() * landmarks[k] + noise.draw(in_sensor);
      observation.position_in_base = base_from_sensor * point_in_sensor;
      const typename Space::PointMatrix turned =
          base_from_sensor.rotation() * in_sensor * base_from_sensor.rotation().transpose();
      observation.covariance = turned.template selfadjointView<Eigen::Lower>();
      observations.push_back(observation);
    }
    estimator->observe(1 + i, observations);
  }
  const double tolerance = TypeParam::kType == Type::kDeadReckoning ? 0.3 : 0.05;  // m: nothing corrects it
  const auto error = pose_error<Space>(estimator->pose().map_from_base, truth);
  EXPECT_LT(error.template head<kPointDim>().norm(), tolerance);
  EXPECT_LT(error.template tail<Space::kTurnDim>().norm(), tolerance);
  ASSERT_EQ(estimator->landmarks().size(), landmarks.size());
  for (const auto& landmark : estimator->landmarks()) {
    EXPECT_TRUE(MatrixNear(landmark.position_in_map, landmarks[landmark.info.source_id], tolerance));
  }
}

/// With a heading that is known the problem is linear, and there is one right answer: the Kalman filter's.
TYPED_TEST(EstimatorContract, GivesTheKalmanFiltersAnswerToALinearProblem) {
  using Space = typename TypeParam::Space;
  constexpr int kPointDim = Space::kPointDim;
  constexpr double kNoTurn = 1e-10;  // rad
  const double sigma = 0.05;         // m, of the start, of each step and of each sighting
  typename Space::PoseMatrix pose_covariance = kNoTurn * kNoTurn * Space::PoseMatrix::Identity();
  pose_covariance.template topLeftCorner<kPointDim, kPointDim>().diagonal().setConstant(sigma * sigma);
  const PoseEstimate<Space> start{this->start().map_from_base, pose_covariance};
  const auto estimator = this->make(start);

  // The same by hand: position and two landmarks, all in the map.
  const auto identity = Space::PointMatrix::Identity();
  const double variance = sigma * sigma;
  Eigen::VectorXd x(3 * kPointDim);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(3 * kPointDim, 3 * kPointDim);
  P.topLeftCorner(kPointDim, kPointDim) = variance * identity;
  x.template head<kPointDim>() = start.map_from_base.translation();
  const auto rotation = start.map_from_base.rotation();
  const typename Space::Point first = this->point(2.0, 0.5);
  const typename Space::Point second = this->point(1.0, -1.0);
  estimator->observe(1, {seen<Space>(first, 1, sigma), seen<Space>(second, 2, sigma)});
  x.template segment<kPointDim>(kPointDim) = start.map_from_base * first;
  x.template tail<kPointDim>() = start.map_from_base * second;
  for (const int row : {kPointDim, 2 * kPointDim}) {
    P.block(row, 0, kPointDim, kPointDim) = P.block(0, row, kPointDim, kPointDim) = variance * identity;
    P.block(row, row, kPointDim, kPointDim) = 2.0 * variance * identity;
  }
  P.block(kPointDim, 2 * kPointDim, kPointDim, kPointDim) = variance * identity;
  P.block(2 * kPointDim, kPointDim, kPointDim, kPointDim) = variance * identity;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kPointDim, 3 * kPointDim);  // sees the first landmark
  H.leftCols(kPointDim) = -rotation.transpose();
  H.middleCols(kPointDim, kPointDim) = rotation.transpose();
  for (int i = 0; i < 5; ++i) {
    const auto step = MotionStep<Space>{typename Space::Pose(), pose_covariance};
    estimator->predict(step);
    P.topLeftCorner(kPointDim, kPointDim) += variance * identity;
    const typename Space::Point z = first + this->point(0.02 * i, -0.03);
    estimator->observe(2 + i, {seen<Space>(z, 1, sigma)});
    const Eigen::MatrixXd S = H * P * H.transpose() + variance * identity;
    const Eigen::MatrixXd K = S.llt().solve(H * P).transpose();
    x += K * (z - H * x);
    P -= K * H * P;
  }

  if (TypeParam::kType == Type::kDeadReckoning) {  // an open loop corrects nothing
    EXPECT_TRUE(this->SamePose(estimator->pose().map_from_base, start.map_from_base, 1e-9));
    return;
  }
  // Particles answer by a sample of 100: to half a standard deviation of the position.
  const double exactness = TypeParam::kSamples ? 0.5 * std::sqrt(P(0, 0)) : 1e-8;
  const double exactness_of_variance = TypeParam::kSamples ? 0.5 * P(0, 0) : 1e-10;
  EXPECT_TRUE(
      MatrixNear(estimator->pose().map_from_base.translation(), x.template head<kPointDim>(), exactness));
  EXPECT_TRUE(MatrixNear(estimator->pose().covariance.topLeftCorner(kPointDim, kPointDim),
                         P.topLeftCorner(kPointDim, kPointDim), exactness_of_variance));
  for (const auto& landmark : estimator->landmarks()) {
    const int row = kPointDim * landmark.info.source_id;
    EXPECT_TRUE(MatrixNear(landmark.position_in_map, x.template segment<kPointDim>(row), exactness));
    EXPECT_TRUE(
        MatrixNear(landmark.covariance, P.block(row, row, kPointDim, kPointDim), exactness_of_variance));
  }
}

/// What rounding might do in a long life.
TYPED_TEST(EstimatorContract, KeepsItsCovarianceInOrderOverAHundredThousandSteps) {
  using Space = typename TypeParam::Space;
  Scenario<Space> scenario(2, 6, 2.5);
  scenario.range = 3.0;
  scenario.motion_sigma = 0.002;
  const PoseEstimate<Space> initial = pose_at<Space>(typename Space::Pose(), 1e-3);
  scenario.start_at(initial);
  EstimatorOptions options = this->options();
  options.particles = 5;
  const auto estimator = this->make(initial, options);
  for (int i = 1; i <= 100000; ++i) {
    estimator->predict(scenario.drive(0.2 * testing::gentle_curve<Space>()));
    estimator->observe(i, scenario.look());
    if (i % 5000 != 0) continue;
    const SlamState<Space> state = estimator->snapshot();
    ASSERT_TRUE(state.covariance.allFinite()) << i;
    ASSERT_TRUE(IsCovariance(state.covariance)) << i;
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
