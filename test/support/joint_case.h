#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>
#include <vector>

#include "test/support/fake_map.h"

namespace kinect_ekf_slam::testing {

/// Landmarks that err together, and what is seen of them, by dense matrices.
struct JointCase {
  FakeMap map;
  Eigen::MatrixXd covariance;  ///< H P H^T of all landmarks, m^2
  std::vector<Observation<Planar>> sightings;

  /// nu of the pairings, one after the other; a landmark below zero: none.
  Eigen::VectorXd innovation(const std::vector<int>& landmarks) const {
    std::vector<double> innovation;
    for (std::size_t k = 0; k < landmarks.size(); ++k) {
      if (landmarks[k] < 0) continue;
      const Eigen::Vector2d nu = sightings[k].position_in_base - map.point_in_base(landmarks[k]);
      innovation.insert(innovation.end(), {nu.x(), nu.y()});
    }
    return Eigen::Map<Eigen::VectorXd>(innovation.data(), static_cast<Eigen::Index>(innovation.size()));
  }
  /// S of the pairings.
  Eigen::MatrixXd innovation_covariance(const std::vector<int>& landmarks) const {
    std::vector<std::size_t> paired;
    for (std::size_t k = 0; k < landmarks.size(); ++k) {
      if (landmarks[k] >= 0) paired.push_back(k);
    }
    const auto size = static_cast<Eigen::Index>(2 * paired.size());
    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < paired.size(); ++i) {
      for (std::size_t j = 0; j < paired.size(); ++j) {
        S.block<2, 2>(2 * i, 2 * j) =
            covariance.block<2, 2>(2 * landmarks[paired[i]], 2 * landmarks[paired[j]]);
      }
      S.block<2, 2>(2 * i, 2 * i) += sightings[paired[i]].covariance;
    }
    return S;
  }
  double squared_distance(const std::vector<int>& landmarks) const {
    const Eigen::VectorXd nu = innovation(landmarks);
    return nu.size() == 0 ? 0.0 : nu.dot(innovation_covariance(landmarks).llt().solve(nu));
  }
};

/// Landmarks in a square of `width` m, seen where they may be; sighting k is truly landmark k.
inline JointCase random_joint_case(std::mt19937_64* random, int landmarks, int sightings, double width) {
  std::uniform_real_distribution<double> place(-0.5 * width, 0.5 * width);
  std::normal_distribution<double> normal;
  const auto white = [&] { return normal(*random); };
  JointCase drawn;
  const Eigen::MatrixXd by_common = Eigen::MatrixXd::NullaryExpr(2 * landmarks, 3, white);
  drawn.covariance = 0.04 * by_common * by_common.transpose() +
                     0.0025 * Eigen::MatrixXd::Identity(2 * landmarks, 2 * landmarks);
  const Eigen::VectorXd error =
      drawn.covariance.llt().matrixL() * Eigen::VectorXd::NullaryExpr(2 * landmarks, white);
  for (int i = 0; i < landmarks; ++i) {
    const Eigen::Vector2d point(3.0 + place(*random), place(*random));
    drawn.map.add(point);
    const Eigen::Vector2d noise = 0.05 * Eigen::Vector2d::NullaryExpr(white);
    if (i < sightings) drawn.sightings.push_back(sighting(point + error.segment<2>(2 * i) + noise));
  }
  drawn.map.set_joint_covariance(drawn.covariance);
  return drawn;
}

}  // namespace kinect_ekf_slam::testing
