#include "kinect_ekf_slam/estimators/ekf.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::IsCovariance;
using testing::MatrixNear;
using testing::PoseNear;

AssociationOptions known_identities(double gate_probability = 0.999999) {
  AssociationOptions options;
  options.type = AssociationOptions::Type::kKnown;
  options.gate_probability = gate_probability;
  options.new_landmark_probability = gate_probability;
  return options;
}

EstimatorOptions plain() {
  EstimatorOptions options;
  options.robust_threshold = 0.0;
  options.replace_after = 0;
  return options;
}

Ekf<Planar> make_ekf(const EstimatorOptions& options = plain(),
                     const AssociationOptions& association = known_identities(), double sigma = 0.1) {
  PoseEstimate<Planar> initial;
  initial.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  return {options, std::shared_ptr<const Associator<Planar>>(make_associator<Planar>(association)), initial};
}

Observation<Planar> sighting(const Eigen::Vector2d& point_in_base, int identity, double sigma = 0.05) {
  Observation<Planar> observation;
  observation.position_in_base = point_in_base;
  observation.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
  observation.signature.source_id = identity;
  return observation;
}

MotionStep<Planar> motion(const Se2& delta, double sigma) {
  return {delta, sigma * sigma * Eigen::Matrix3d::Identity()};
}

TEST(Ekf, PredictionMatchesSampledMotion) {
  auto ekf = make_ekf();
  ekf.predict(motion(Se2(0.3, 0.1, 0.4), 0.02));
  const PoseEstimate<Planar> before = ekf.pose();
  const MotionStep<Planar> step = motion(Se2(0.5, 0.0, -0.6), 0.03);
  ekf.predict(step);

  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Eigen::Matrix3d root = before.covariance.llt().matrixL();
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  const int runs = 40000;
  const double small = 0.05;  // shrunk errors: the comparison is with the linear prediction
  for (int i = 0; i < runs; ++i) {
    const Eigen::Vector3d error =
        small * root * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Eigen::Vector3d noise =
        small * 0.03 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Se2 pose(before.map_from_base.translation() + error.head<2>(),
                   before.map_from_base.angle() + error.z());
    const Se2 moved = pose * step.delta * Se2::exp(noise);
    Eigen::Vector3d moved_error;
    moved_error << moved.translation() - ekf.pose().map_from_base.translation(),
        wrap_angle(moved.angle() - ekf.pose().map_from_base.angle());
    sampled += moved_error * moved_error.transpose() / (runs * small * small);
  }
  EXPECT_TRUE(MatrixNear(ekf.pose().covariance, sampled, 0.03 * sampled.norm()));
}

/// The update against the textbook's formulas, written out with full matrices and an explicit inverse.
TEST(Ekf, UpdateIsTheTextbooks) {
  auto ekf = make_ekf();
  ekf.predict(motion(Se2(0.2, 0.0, 0.3), 0.05));
  ekf.observe(1, {sighting({1.0, 0.5}, 1), sighting({1.5, -0.5}, 2), sighting({2.0, 0.1}, 3)});
  ekf.predict(motion(Se2(0.3, 0.0, -0.5), 0.05));
  const SlamState<Planar> prior = ekf.snapshot();
  ASSERT_TRUE(IsCovariance(prior.covariance));

  const auto z1 = sighting({0.8, 0.9}, 1);
  const auto z3 = sighting({1.6, 1.0}, 3);
  const UpdateReport report = ekf.observe(1, {z3, z1});
  ASSERT_EQ(report.dof, 4);

  const auto h = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {  // x: pose error, landmarks
    const Se2 pose(prior.map_from_base.translation() + x.head<2>(), prior.map_from_base.angle() + x(2));
    Eigen::VectorXd z(4);
    z << pose.inverse() * Eigen::Vector2d(prior.landmarks_in_map.segment<2>(4) + x.segment<2>(7)),
        pose.inverse() * Eigen::Vector2d(prior.landmarks_in_map.segment<2>(0) + x.segment<2>(3));
    return z;
  };
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(9);
  const Eigen::MatrixXd H = testing::numerical_jacobian(h, zero);
  const Eigen::MatrixXd R = 0.05 * 0.05 * Eigen::MatrixXd::Identity(4, 4);
  const Eigen::MatrixXd& P = prior.covariance;
  const Eigen::MatrixXd S = H * P * H.transpose() + R;
  const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
  Eigen::VectorXd z(4);
  z << z3.position_in_base, z1.position_in_base;
  const Eigen::VectorXd nu = z - h(zero);
  const Eigen::VectorXd dx = K * nu;

  const SlamState<Planar> posterior = ekf.snapshot();
  EXPECT_TRUE(MatrixNear(posterior.covariance, (Eigen::MatrixXd::Identity(9, 9) - K * H) * P, 1e-8));
  EXPECT_TRUE(PoseNear(
      posterior.map_from_base,
      Se2(prior.map_from_base.translation() + dx.head<2>(), prior.map_from_base.angle() + dx(2)), 1e-8));
  EXPECT_TRUE(MatrixNear(posterior.landmarks_in_map, prior.landmarks_in_map + dx.tail(6), 1e-8));
  EXPECT_NEAR(report.nis, nu.dot(S.inverse() * nu), 1e-6);
}

TEST(Ekf, NewLandmarkCarriesItsCrossCovariance) {
  auto ekf = make_ekf();
  ekf.predict(motion(Se2(0.2, 0.1, 0.7), 0.05));
  ekf.observe(1, {sighting({1.0, 0.5}, 1)});
  const SlamState<Planar> prior = ekf.snapshot();
  ekf.observe(1, {sighting({1.5, -0.4}, 2)});
  const SlamState<Planar> grown = ekf.snapshot();

  const auto place = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {  // pose error, measurement error
    const Se2 pose(prior.map_from_base.translation() + x.head<2>(), prior.map_from_base.angle() + x(2));
    return pose * Eigen::Vector2d(Eigen::Vector2d(1.5, -0.4) + x.tail<2>());
  };
  const Eigen::MatrixXd G = testing::numerical_jacobian(place, Eigen::VectorXd::Zero(5));
  Eigen::MatrixXd expected(7, 7);
  expected.topLeftCorner(5, 5) = prior.covariance;
  expected.bottomLeftCorner(2, 5) = G.leftCols(3) * prior.covariance.topRows(3);
  expected.topRightCorner(5, 2) = expected.bottomLeftCorner(2, 5).transpose();
  expected.bottomRightCorner(2, 2) =
      G.leftCols(3) * prior.covariance.topLeftCorner(3, 3) * G.leftCols(3).transpose() +
      0.05 * 0.05 * G.rightCols(2) * G.rightCols(2).transpose();
  EXPECT_TRUE(MatrixNear(grown.covariance, expected, 1e-8));
  EXPECT_TRUE(
      MatrixNear(grown.landmarks_in_map.tail(2), prior.map_from_base * Eigen::Vector2d(1.5, -0.4), 1e-12));
}

}  // namespace
}  // namespace kinect_ekf_slam
