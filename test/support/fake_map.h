#pragma once

#include <utility>
#include <vector>

#include "kinect_ekf_slam/association/associator.h"

namespace kinect_ekf_slam::testing {

/// A map that expects what it is told to: association without any filter.
class FakeMap : public PredictedMap<Planar> {
 public:
  /// Expects the landmark at `point_in_base`, each axis with `sigma`.
  FakeMap& add(const Eigen::Vector2d& point_in_base, double sigma = 0.05, int source_id = kNoId) {
    LandmarkInfo info;
    info.id = 100 + size();
    info.source_id = source_id;
    landmarks_.push_back({info, point_in_base, sigma * sigma * Eigen::Matrix2d::Identity()});
    return *this;
  }
  void set_covariance(int landmark, const Eigen::Matrix2d& covariance) {
    landmarks_[landmark].covariance = covariance;
  }
  /// Of all landmarks' expected points, one after the other.
  void set_joint_covariance(const Eigen::MatrixXd& covariance) {
    joint_covariance_ = covariance;
    for (int i = 0; i < size(); ++i) set_covariance(i, cross_covariance(i, i));
  }
  /// What is known of a landmark, to be written.
  LandmarkInfo& known_of(int landmark) { return landmarks_[landmark].info; }

  int size() const override { return static_cast<int>(landmarks_.size()); }
  const LandmarkInfo& info(int landmark) const override { return landmarks_[landmark].info; }
  Eigen::Vector2d point_in_base(int landmark) const override { return landmarks_[landmark].point; }
  Eigen::Matrix2d covariance(int landmark) const override { return landmarks_[landmark].covariance; }
  Eigen::Matrix2d cross_covariance(int a, int b) const override {
    if (joint_covariance_.size() == 0) return Eigen::Matrix2d::Zero();
    return joint_covariance_.block<2, 2>(2 * a, 2 * b);
  }

 private:
  struct Entry {
    LandmarkInfo info;
    Eigen::Vector2d point;
    Eigen::Matrix2d covariance;
  };
  std::vector<Entry> landmarks_;
  Eigen::MatrixXd joint_covariance_;
};

inline Observation<Planar> sighting(const Eigen::Vector2d& point_in_base, int identity = kNoId,
                                    double sigma = 0.05) {
  Observation<Planar> observation;
  observation.position_in_base = point_in_base;
  observation.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
  observation.signature.source_id = identity;
  return observation;
}

}  // namespace kinect_ekf_slam::testing
