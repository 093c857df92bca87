#pragma once

#include <random>
#include <vector>

#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam::benchmarks {

constexpr int kInView = 8;              ///< landmarks that are seen at a time
constexpr double kRangeSigma = 0.03;    // m
constexpr double kBearingSigma = 0.01;  // rad, and of the elevation

/// A sighting as polar sensors tell it; what the estimators take is made of it.
struct Polar {
  double range;      ///< m
  double bearing;    ///< rad
  double elevation;  ///< rad; zero in the plane
  int identity;
};

/// What the robot does and sees in one step.
template <class Space>
struct Look {
  MotionStep<Space> motion;
  std::vector<Polar> sightings;
  std::vector<Observation<Space>> observations() const;
};

/// A robot that drives at 0.22 m/s and looks ten times a second, to and fro over a square with one landmark
/// every 6 m^2, in space at heights within half a metre. The eight nearest ones are seen, in any direction.
template <class Space>
class Drive {
 public:
  using Point = typename Space::Point;
  using Pose = typename Space::Pose;

  explicit Drive(int landmarks);
  Look<Space> next();

  int landmark_count() const { return static_cast<int>(landmarks_.size()); }
  const Point& landmark(int identity) const { return landmarks_[static_cast<std::size_t>(identity)]; }
  const Pose& map_from_base() const { return map_from_base_; }
  /// A map of all landmarks that is known to some centimetres, and to a decimetre where it lies as a whole.
  SlamState<Space> known_map();

 private:
  double noise(double sigma) { return sigma * normal_(random_); }

  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
  double side_;  ///< m
  std::vector<Point> landmarks_;
  Pose map_from_base_;
  std::vector<Eigen::Vector2d> corners_;  ///< of the way, the next one last
};

/// The landmarks of a Drive, eight new ones a look, and to where it starts.
template <class Space>
std::vector<Look<Space>> survey(int landmarks);

}  // namespace kinect_ekf_slam::benchmarks
