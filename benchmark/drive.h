#pragma once

#include <random>
#include <vector>

#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam::benchmarks {

constexpr int kInView = 8;              ///< landmarks that are seen at a time
constexpr double kRangeSigma = 0.03;    // m
constexpr double kBearingSigma = 0.01;  // rad

/// A sighting as polar sensors tell it; what the estimators take is made of it.
struct Polar {
  double range;    ///< m
  double bearing;  ///< rad
  int identity;
};
Observation<Planar> to_observation(const Polar& polar);

/// What the robot does and sees in one step.
struct Look {
  MotionStep<Planar> motion;
  std::vector<Polar> sightings;
  std::vector<Observation<Planar>> observations() const;
};

std::vector<Look> survey(int landmarks);

/// A robot that drives at 0.22 m/s and looks ten times a second, to and fro over a square with one landmark
/// every 6 m^2. The eight nearest ones are seen, at any bearing.
class Drive {
 public:
  explicit Drive(int landmarks);
  Look next();

  int landmark_count() const { return static_cast<int>(landmarks_.size()); }
  const Eigen::Vector2d& landmark(int identity) const {
    return landmarks_[static_cast<std::size_t>(identity)];
  }
  /// A map of all landmarks that is known to some centimetres, and to a decimetre where it lies as a whole.
  SlamState<Planar> known_map();

 private:
  friend std::vector<Look> survey(int landmarks);
  double noise(double sigma) { return sigma * normal_(random_); }

  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
  double side_;  ///< m
  std::vector<Eigen::Vector2d> landmarks_;
  Se2 map_from_base_;
  std::vector<Eigen::Vector2d> corners_;  ///< of the way, the next one last
};

/// The landmarks of a Drive, eight new ones a look, and to where it starts.
std::vector<Look> survey(int landmarks);

}  // namespace kinect_ekf_slam::benchmarks
