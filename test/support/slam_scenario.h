#pragma once

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "kinect_ekf_slam/estimators/factory.h"

namespace kinect_ekf_slam::testing {

inline AssociationOptions known_identities(double gate_probability = 0.999999) {
  AssociationOptions options;
  options.type = AssociationOptions::Type::kKnown;
  options.gate_probability = gate_probability;
  return options;
}

/// An estimator without any precaution against outliers: what the textbook says.
inline EstimatorOptions textbook(EstimatorOptions::Type type = EstimatorOptions::Type::kEkf) {
  EstimatorOptions options;
  options.type = type;
  options.robust_threshold = 0.0;
  options.replace_after = 0;
  return options;
}

template <class Space>
PoseEstimate<Space> pose_at(const typename Space::Pose& pose, double sigma) {
  return {pose, sigma * sigma * Space::PoseMatrix::Identity()};
}

template <class Space>
MotionStep<Space> motion(const typename Space::Pose& delta, double sigma) {
  return {delta, sigma * sigma * Space::PoseMatrix::Identity()};
}

template <class Space>
Observation<Space> seen(const typename Space::Point& point_in_base, int identity, double sigma = 0.05) {
  Observation<Space> observation;
  observation.position_in_base = point_in_base;
  observation.covariance = sigma * sigma * Space::PointMatrix::Identity();
  observation.signature.source_id = identity;
  return observation;
}

/// A robot that drives among landmarks, what its sensors say of it, and how it really is. Any space.
template <class Space>
class Scenario {
 public:
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;

  double motion_sigma = 0.01;  ///< m and rad, per step and axis
  double sensor_sigma = 0.05;  ///< m
  double range = 4.0;          ///< m: nearer landmarks are seen, all round

  Scenario(std::uint64_t seed, int landmarks, double world = 5.0) : random_(seed) {
    std::uniform_real_distribution<double> place(-world, world);
    for (int i = 0; i < landmarks; ++i) {
      landmarks_.push_back(Point::NullaryExpr([&] { return place(random_); }));
    }
  }

  void start_at(const PoseEstimate<Space>& initial) {
    const typename Space::PoseVector error = draw(initial.covariance);
    true_pose_ =
        Space::retract(initial.map_from_base, local_from_error<Space>(initial.map_from_base) * error);
  }

  /// The robot moves; what the odometry says of it.
  MotionStep<Space> drive(const typename Space::PoseVector& twist) {
    const MotionStep<Space> step = motion<Space>(Pose::exp(twist), motion_sigma);
    true_pose_ = true_pose_ * step.delta * Pose::exp(draw(step.covariance));
    return step;
  }

  /// What is seen from here; the landmark's index is its identity.
  std::vector<Observation<Space>> look() {
    std::vector<Observation<Space>> observations;
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      const Point point = true_pose_.inverse() * landmarks_[i];
      if (point.norm() > range) continue;
      Observation<Space> observation = seen<Space>(point, static_cast<int>(i), sensor_sigma);
      observation.position_in_base += draw(observation.covariance);
      observations.push_back(observation);
    }
    return observations;
  }

  const Pose& true_pose() const { return true_pose_; }
  const std::vector<Point>& landmarks() const { return landmarks_; }

  /// Error of an estimate in its own terms.
  typename Space::PoseVector error_of(const Pose& estimate) const {
    return pose_error<Space>(estimate, true_pose_);
  }

  template <class Matrix>
  Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1> draw(const Matrix& covariance) {
    using Vector = Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1>;
    const Vector white = Vector::NullaryExpr(covariance.rows(), [this] { return normal_(random_); });
    return covariance.llt().matrixL() * white;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<Point> landmarks_;
  Pose true_pose_;
};

/// Normalised estimation error squared: chi-square distributed when the covariance tells the truth.
template <class Space>
double nees(const Scenario<Space>& scenario, const PoseEstimate<Space>& estimate) {
  const auto error = scenario.error_of(estimate.map_from_base);
  return error.dot(estimate.covariance.llt().solve(error));
}

/// A twist that drives a gentle curve.
template <class Space>
typename Space::PoseVector gentle_curve() {
  typename Space::PoseVector twist = Space::PoseVector::Zero();
  twist(0) = 0.2;
  twist(Space::kPoseDim - 1) = 0.1;
  return twist;
}

}  // namespace kinect_ekf_slam::testing
