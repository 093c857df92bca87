/// What a map's keeper does to a filter's landmarks: two that turn out to be one, and those that go.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::pose_at;
using testing::Scenario;

using Type = EstimatorOptions::Type;
constexpr double kWideGate = 1e6;

template <class SpaceType, Type kTypeValue>
struct Case {
  using Space = SpaceType;
  static constexpr Type kType = kTypeValue;
};
using Cases =
    ::testing::Types<Case<Planar, Type::kEkf>, Case<Planar, Type::kInvariantEkf>,
                     Case<Planar, Type::kCompressedEkf>, Case<Planar, Type::kUkf>, Case<Spatial, Type::kEkf>,
                     Case<Spatial, Type::kInvariantEkf>, Case<Spatial, Type::kCompressedEkf>>;

template <class MergeCase>
class Merge : public ::testing::Test {
 protected:
  using CaseSpace = typename MergeCase::Space;
  using Filter = std::unique_ptr<KalmanSlam<CaseSpace>>;
  static constexpr int kPoint = CaseSpace::kPointDim;
  static constexpr int kPose = CaseSpace::kPoseDim;

  /// A map of eight landmarks in which the detector took one for two: from half way on it is called 100.
  static Filter made_a_map(double sensor_sigma) {
    Scenario<CaseSpace> scenario(3, 8, 2.0);
    scenario.sensor_sigma = sensor_sigma;
    EstimatorOptions options = testing::textbook(MergeCase::kType);
    options.active_radius = 2.0;
    const auto start = pose_at<CaseSpace>(typename CaseSpace::Pose(), 0.01);
    Filter filter = make_kalman<CaseSpace>(options, testing::known_identities(), start);
    scenario.start_at(start);
    for (int i = 0; i < 20; ++i) {
      filter->predict(scenario.drive(testing::gentle_curve<CaseSpace>()));
      auto observations = scenario.look();
      for (auto& observation : observations) {
        if (i >= 10 && observation.signature.source_id == 2) observation.signature.source_id = 100;
      }
      filter->observe(i + 1, observations);
    }
    return filter;
  }
  static int index_in(const SlamState<CaseSpace>& state, int id) {
    for (std::size_t i = 0; i < state.infos.size(); ++i) {
      if (state.infos[i].id == id) return static_cast<int>(i);
    }
    ADD_FAILURE() << "no landmark " << id;
    return 0;
  }
};

struct CaseNames {
  template <class MergeCase>
  static std::string GetName(int /*index*/) {
    return std::string(MergeCase::Space::kName) + "_" + kEstimators[static_cast<int>(MergeCase::kType)].name;
  }
};
TYPED_TEST_SUITE(Merge, Cases, CaseNames);

/// The joint Gaussian given that the two are at one place, by dense matrices (to a millimetre).
TYPED_TEST(Merge, IsTheGaussianGivenThatTheTwoAreOne) {
  using Space = typename TypeParam::Space;
  const auto filter = this->made_a_map(1e-2);
  const SlamState<Space> before = filter->snapshot();
  const int kept = this->index_in(before, 2);
  const int dropped = this->index_in(before, 100);
  const auto size = before.covariance.rows();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(this->kPoint, size);
  H.middleCols(this->kPose + this->kPoint * kept, this->kPoint).setIdentity();
  H.middleCols(this->kPose + this->kPoint * dropped, this->kPoint) = -Space::PointMatrix::Identity();
  const Eigen::MatrixXd S =
      H * before.covariance * H.transpose() + 1e-6 * Eigen::MatrixXd::Identity(this->kPoint, this->kPoint);
  const Eigen::MatrixXd K = before.covariance * H.transpose() * S.inverse();
  const Eigen::VectorXd error = -K * H.rightCols(size - this->kPose) * before.landmarks_in_map;
  const Eigen::MatrixXd covariance = before.covariance - K * S * K.transpose();

  ASSERT_TRUE(filter->merge(2, 100, kWideGate));
  const SlamState<Space> after = filter->snapshot();
  ASSERT_EQ(after.infos.size(), before.infos.size() - 1);
  EXPECT_TRUE(IsCovariance(after.covariance));
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(after.covariance).eigenvalues().minCoeff(), 0.0);

  // The invariant filter moves its estimate on a curve, which differs in the second order.
  const bool is_linear = TypeParam::kType != Type::kInvariantEkf;
  const double tolerance = is_linear ? 1e-10 : 2e-2 * error.norm();
  const double covariance_tolerance = is_linear ? 1e-10 : 2e-2 * covariance.diagonal().maxCoeff();
  EXPECT_TRUE(MatrixNear(pose_error<Space>(before.map_from_base, after.map_from_base),
                         error.head(this->kPose), tolerance));
  for (const LandmarkInfo& info : after.infos) {
    const int now = this->kPoint * this->index_in(after, info.id);
    const int then = this->kPoint * this->index_in(before, info.id);
    EXPECT_TRUE(MatrixNear(
        after.landmarks_in_map.segment(now, this->kPoint),
        before.landmarks_in_map.segment(then, this->kPoint) + error.segment(this->kPose + then, this->kPoint),
        tolerance))
        << "landmark " << info.id;
    EXPECT_TRUE(MatrixNear(after.covariance.middleRows(this->kPose + now, this->kPoint).leftCols(this->kPose),
                           covariance.middleRows(this->kPose + then, this->kPoint).leftCols(this->kPose),
                           covariance_tolerance));
    EXPECT_TRUE(
        MatrixNear(after.covariance.block(this->kPose + now, this->kPose + now, this->kPoint, this->kPoint),
                   covariance.block(this->kPose + then, this->kPose + then, this->kPoint, this->kPoint),
                   covariance_tolerance));
  }
}

TYPED_TEST(Merge, TheOneThatStaysKnowsWhatBothKnew) {
  const auto filter = this->made_a_map(1e-2);
  const auto before = filter->snapshot();
  const auto sightings = before.infos[this->index_in(before, 2)].observations +
                         before.infos[this->index_in(before, 100)].observations;
  ASSERT_TRUE(filter->merge(2, 100, kWideGate));
  const auto after = filter->snapshot();
  EXPECT_EQ(after.infos[this->index_in(after, 2)].observations, sightings);
  for (const LandmarkInfo& info : after.infos) EXPECT_NE(info.id, 100);
}

TYPED_TEST(Merge, RefusesWhatCannotBeOneAndChangesNothing) {
  const auto filter = this->made_a_map(1e-2);
  const auto before = filter->snapshot();
  EXPECT_FALSE(filter->merge(2, 5, 20.0)) << "far apart";
  EXPECT_FALSE(filter->merge(2, 2, kWideGate)) << "one and the same";
  EXPECT_FALSE(filter->merge(2, 4711, kWideGate)) << "no such one";
  EXPECT_FALSE(filter->merge(4711, 2, kWideGate));
  EXPECT_FALSE(filter->remove(4711));
  EXPECT_FALSE(filter->set_confirmed(4711, false));
  const auto after = filter->snapshot();
  EXPECT_TRUE(MatrixNear(after.landmarks_in_map, before.landmarks_in_map, 0.0));
  EXPECT_TRUE(MatrixNear(after.covariance, before.covariance, 1e-15));
  EXPECT_EQ(after.infos.size(), before.infos.size());
}

TYPED_TEST(Merge, ARemovedLandmarkLeavesTheOthersAsTheyAre) {
  using Space = typename TypeParam::Space;
  const auto filter = this->made_a_map(1e-2);
  const SlamState<Space> before = filter->snapshot();
  ASSERT_TRUE(filter->remove(2));
  const SlamState<Space> after = filter->snapshot();
  ASSERT_EQ(after.infos.size(), before.infos.size() - 1);
  for (const LandmarkInfo& info : after.infos) {
    ASSERT_NE(info.id, 2);
    const int now = this->kPoint * this->index_in(after, info.id);
    const int then = this->kPoint * this->index_in(before, info.id);
    EXPECT_TRUE(MatrixNear(after.landmarks_in_map.segment(now, this->kPoint),
                           before.landmarks_in_map.segment(then, this->kPoint), 0.0));
    EXPECT_TRUE(MatrixNear(
        after.covariance.middleRows(this->kPose + now, this->kPoint).leftCols(this->kPose),
        before.covariance.middleRows(this->kPose + then, this->kPoint).leftCols(this->kPose), 1e-15));
  }
}

TYPED_TEST(Merge, ABeliefInALandmarkIsKeptWithIt) {
  const auto filter = this->made_a_map(1e-2);
  ASSERT_TRUE(filter->set_confirmed(2, false));
  EXPECT_FALSE(filter->snapshot().infos[this->index_in(filter->snapshot(), 2)].confirmed);
  ASSERT_TRUE(filter->merge(2, 100, kWideGate));
  EXPECT_TRUE(filter->snapshot().infos[this->index_in(filter->snapshot(), 2)].confirmed)
      << "the other one was believed in";
}

/// The two halves of observe() make the whole.
TYPED_TEST(Merge, ExpectAndApplyDoWhatObserveDoes) {
  using Space = typename TypeParam::Space;
  const auto whole = this->made_a_map(1e-2);
  const auto halves = this->made_a_map(1e-2);
  const auto landmark = whole->landmarks()[3];
  const typename Space::Point in_base = whole->pose().map_from_base.inverse() * landmark.position_in_map;
  std::vector<Observation<Space>> observations = {testing::seen<Space>(in_base, landmark.info.id)};
  whole->observe(100, observations);

  const auto expected = halves->expect(observations);
  int index = 0;
  while (index < expected.size() && expected.info(index).id != landmark.info.id) ++index;
  ASSERT_LT(index, expected.size());
  EXPECT_TRUE(MatrixNear(expected.point_in_base(index), in_base, 1e-9));
  Assignment assignment{Verdict::kMatched, index, 0.0};
  const UpdateReport report = halves->apply(100, observations, {assignment});
  EXPECT_EQ(report.assignments[0].landmark, landmark.info.id) << "told by its id";
  EXPECT_TRUE(MatrixNear(halves->snapshot().covariance, whole->snapshot().covariance, 1e-12));
  EXPECT_TRUE(MatrixNear(halves->snapshot().landmarks_in_map, whole->snapshot().landmarks_in_map, 1e-12));
}

}  // namespace
}  // namespace kinect_ekf_slam
