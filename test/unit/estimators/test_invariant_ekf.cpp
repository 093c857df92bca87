#include "kinect_ekf_slam/estimators/invariant_ekf.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::motion;
using testing::pose_at;
using testing::seen;

template <class Space>
class InvariantEkfOf : public ::testing::Test {
 protected:
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;

  /// T of e = T xi, equation (7.2): the EKF's error from the error of a rigid motion.
  static Eigen::MatrixXd error_from_invariant(const SlamState<Space>& state) {
    const auto size = state.covariance.rows();
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(size, size);
    const auto by_turn = [&](Eigen::Index row, const Point& point) {
      T.template block<Space::kPointDim, Space::kTurnDim>(row, Space::kPointDim) = Space::by_turn(point);
    };
    by_turn(0, state.map_from_base.translation());
    for (Eigen::Index i = 0; i < state.landmarks_in_map.size(); i += Space::kPointDim) {
      by_turn(Space::kPoseDim + i, state.landmarks_in_map.template segment<Space::kPointDim>(i));
    }
    return T;
  }
  static std::unique_ptr<SlamEstimator<Space>> made(const EstimatorOptions& options) {
    auto filter = make_estimator<Space>(options, testing::known_identities(),
                                        pose_at<Space>(Pose::exp(0.3 * Space::PoseVector::Ones()), 0.1));
    Point first = Point::Constant(0.5);
    first(0) = 2.0;
    Point second = Point::Constant(-0.4);
    second(0) = 1.0;
    filter->observe(1, {seen<Space>(first, 1), seen<Space>(second, 2)});
    typename Space::PoseVector twist = Space::PoseVector::Constant(0.2);
    filter->predict(motion<Space>(Pose::exp(twist), 0.1));
    return filter;
  }
  /// A landmark that is seen `aside` m from where it is expected, along each axis.
  static Observation<Space> displaced_sighting(const SlamEstimator<Space>& filter, int identity,
                                               double aside) {
    for (const auto& landmark : filter.landmarks()) {
      if (landmark.info.source_id != identity) continue;
      const Point expected = filter.pose().map_from_base.inverse() * landmark.position_in_map;
      return seen<Space>(expected + Point::Constant(aside), identity);
    }
    throw std::invalid_argument("no such landmark");
  }
};

using Spaces = ::testing::Types<Planar, Spatial>;
TYPED_TEST_SUITE(InvariantEkfOf, Spaces);

/// The filter as its inventors write it: K from the covariance of xi, the estimate moved by Exp(K nu), and
/// the covariance of xi unmoved.
TYPED_TEST(InvariantEkfOf, IsTheFilterWrittenInTheInvariantError) {
  using Space = TypeParam;
  constexpr int kPointDim = Space::kPointDim;
  const auto filter = this->made(testing::textbook(EstimatorOptions::Type::kInvariantEkf));
  const SlamState<Space> prior = filter->snapshot();
  const auto sighting = this->displaced_sighting(*filter, 1, 0.15);
  const UpdateReport report = filter->observe(2, {sighting});
  ASSERT_EQ(report.dof, kPointDim);
  const SlamState<Space> posterior = filter->snapshot();

  const Eigen::MatrixXd T = this->error_from_invariant(prior);
  const Eigen::MatrixXd P = T.inverse() * prior.covariance * T.inverse().transpose();
  const auto moved = [&](const Eigen::VectorXd& xi) {
    SlamState<Space> state = prior;
    typename Space::PoseVector rigid = xi.head<Space::kPoseDim>();
    state.map_from_base = Space::Pose::exp(rigid) * prior.map_from_base;
    for (Eigen::Index i = 0; i < prior.landmarks_in_map.size(); i += kPointDim) {
      rigid.template head<kPointDim>() = xi.segment<kPointDim>(Space::kPoseDim + i);
      const typename Space::Point landmark = prior.landmarks_in_map.template segment<kPointDim>(i);
      state.landmarks_in_map.template segment<kPointDim>(i) = Space::Pose::exp(rigid) * landmark;
    }
    return state;
  };
  const auto h = [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd {
    const SlamState<Space> state = moved(xi);
    return state.map_from_base.inverse() *
           typename Space::Point(state.landmarks_in_map.template head<kPointDim>());
  };
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(P.rows());
  const Eigen::MatrixXd H = testing::numerical_jacobian(h, zero);
  const Eigen::MatrixXd S = H * P * H.transpose() + sighting.covariance;
  const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
  const SlamState<Space> expected = moved(K * (sighting.position_in_base - h(zero)));
  const Eigen::MatrixXd T_after = this->error_from_invariant(posterior);
  const Eigen::MatrixXd unmoved = (Eigen::MatrixXd::Identity(P.rows(), P.rows()) - K * H) * P;

  EXPECT_TRUE(MatrixNear(Space::to_3d(posterior.map_from_base).matrix(),
                         Space::to_3d(expected.map_from_base).matrix(), 1e-8));
  EXPECT_TRUE(MatrixNear(posterior.landmarks_in_map, expected.landmarks_in_map, 1e-8));
  EXPECT_TRUE(MatrixNear(posterior.covariance, T_after * unmoved * T_after.transpose(), 1e-8));
  EXPECT_TRUE(IsCovariance(posterior.covariance));
}

/// Nothing that a robot sees tells where the map stands: moving the whole changes no expected sighting, so no
/// sighting may seem to tell. Of the EKF that is not true.
TYPED_TEST(InvariantEkfOf, NeverLearnsWhereTheMapStands) {
  using Space = TypeParam;
  const auto information_on_the_frame = [&](EstimatorOptions::Type type) {
    const auto filter = this->made(testing::textbook(type));
    // The information of the sightings: that of the state after, less that before (no motion in between).
    const SlamState<Space> before = filter->snapshot();
    for (int i = 0; i < 5; ++i) {  // they pull, so the estimate moves and the EKF linearises elsewhere
      const UpdateReport report = filter->observe(
          2 + i, {this->displaced_sighting(*filter, 1, 0.1), this->displaced_sighting(*filter, 2, -0.1)});
      EXPECT_EQ(report.dof, 2 * Space::kPointDim);
    }
    const SlamState<Space> after = filter->snapshot();
    const Eigen::MatrixXd T = this->error_from_invariant(before);
    const Eigen::MatrixXd T_after = this->error_from_invariant(after);
    const Eigen::MatrixXd prior = T.inverse() * before.covariance * T.inverse().transpose();
    const Eigen::MatrixXd posterior = T_after.inverse() * after.covariance * T_after.inverse().transpose();
    // A turn of everything: xi with the same turn, and no other part, for the pose and all landmarks.
    Eigen::VectorXd turn = Eigen::VectorXd::Zero(prior.rows());
    turn(Space::kPoseDim - 1) = 1.0;
    return turn.dot((posterior.inverse() - prior.inverse()) * turn) / turn.dot(prior.inverse() * turn);
  };
  EXPECT_NEAR(information_on_the_frame(EstimatorOptions::Type::kInvariantEkf), 0.0, 1e-6);
  EXPECT_GT(std::abs(information_on_the_frame(EstimatorOptions::Type::kEkf)), 1e-3);
}

}  // namespace
}  // namespace kinect_ekf_slam
