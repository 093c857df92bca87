#include "benchmark/drive.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam::benchmarks {
namespace {

constexpr double kSpacing = 2.45;  // m between landmarks
constexpr double kStep = 0.022;    // m

Polar sighting(const Se2& map_from_base, const Eigen::Vector2d& landmark, int identity) {
  const Eigen::Vector2d point = map_from_base.inverse() * landmark;
  return {point.norm(), std::atan2(point.y(), point.x()), identity};
}

MotionStep<Planar> motion(const Se2& delta) {
  const Eigen::Vector3d sigmas(0.002, 0.001, 0.002);  // m, m, rad
  return {delta, Eigen::Matrix3d(sigmas.cwiseAbs2().asDiagonal())};
}

}  // namespace

Observation<Planar> to_observation(const Polar& polar) {
  const Eigen::Vector2d ray(std::cos(polar.bearing), std::sin(polar.bearing));
  Eigen::Matrix2d axes;  // along and across the ray
  axes << ray.x(), -ray.y(), ray.y(), ray.x();
  const Eigen::Vector2d sigmas(kRangeSigma, polar.range * kBearingSigma);
  Observation<Planar> observation;
  observation.position_in_base = polar.range * ray;
  observation.covariance = axes * sigmas.cwiseAbs2().asDiagonal() * axes.transpose();
  observation.signature.source_id = polar.identity;
  return observation;
}

std::vector<Observation<Planar>> Look::observations() const {
  std::vector<Observation<Planar>> observations;
  for (const Polar& polar : sightings) observations.push_back(to_observation(polar));
  return observations;
}

Drive::Drive(int landmarks) : side_(kSpacing * std::ceil(std::sqrt(landmarks))) {
  std::uniform_real_distribution<double> place(-0.3 * kSpacing, 0.3 * kSpacing);
  const int in_a_row = static_cast<int>(std::ceil(std::sqrt(landmarks)));
  for (int i = 0; i < landmarks; ++i) {
    const Eigen::Vector2d cell(i % in_a_row + 0.5, i / in_a_row + 0.5);
    landmarks_.push_back(kSpacing * cell + Eigen::Vector2d(place(random_), place(random_)));
  }
  constexpr double kLane = 5.0;  // m
  const double border = 0.2 * side_;
  bool forth = true;
  for (double y = border; y < side_ - border; y += kLane, forth = !forth) {
    corners_.emplace_back(forth ? border : side_ - border, y);
    corners_.emplace_back(forth ? side_ - border : border, y);
  }
  std::reverse(corners_.begin(), corners_.end());
  map_from_base_ = Se2(corners_.back(), 0.0);
}

Look Drive::next() {
  const Eigen::Vector2d ahead = map_from_base_.inverse() * corners_.back();
  if (ahead.norm() < kStep) std::rotate(corners_.begin(), corners_.end() - 1, corners_.end());
  constexpr double kTurn = 0.1;  // rad
  const double turn = std::clamp(std::atan2(ahead.y(), ahead.x()), -kTurn, kTurn);
  const Se2 delta(std::abs(turn) < kTurn ? kStep : 0.0, 0.0, turn);
  Look look{motion(delta), {}};
  map_from_base_ = map_from_base_ * delta * Se2(noise(0.002), noise(0.001), noise(0.002));

  std::vector<int> nearest(landmarks_.size());
  std::iota(nearest.begin(), nearest.end(), 0);
  const auto distance = [this](int i) { return (landmark(i) - map_from_base_.translation()).squaredNorm(); };
  std::partial_sort(nearest.begin(), nearest.begin() + kInView, nearest.end(),
                    [&](int left, int right) { return distance(left) < distance(right); });
  for (int k = 0; k < kInView; ++k) {
    const int identity = nearest[static_cast<std::size_t>(k)];
    Polar polar = sighting(map_from_base_, landmark(identity), identity);
    polar.range += noise(kRangeSigma);
    polar.bearing += noise(kBearingSigma);
    look.sightings.push_back(polar);
  }
  return look;
}

SlamState<Planar> Drive::known_map() {
  constexpr double kOwn = 0.03;     // m, of a landmark or the pose
  constexpr double kWhole = 0.1;    // m, where the map lies
  constexpr double kTurned = 0.01;  // rad, of the pose
  const int size = 3 + 2 * landmark_count();
  SlamState<Planar> state;
  state.map_from_base = map_from_base_;
  state.landmarks_in_map.resize(size - 3);
  Eigen::MatrixX2d shift = Eigen::MatrixX2d::Zero(size, 2);  // of all by the whole
  shift(0, 0) = shift(1, 1) = kWhole;
  for (int i = 0; i < landmark_count(); ++i) {
    LandmarkInfo info;
    info.id = info.source_id = i;
    info.observations = 10;
    state.infos.push_back(info);
    state.landmarks_in_map.segment<2>(2 * i) = landmark(i) + Eigen::Vector2d(noise(kOwn), noise(kOwn));
    shift.middleRows<2>(3 + 2 * i).diagonal().setConstant(kWhole);
  }
  state.covariance = shift * shift.transpose();
  state.covariance.diagonal().array() += kOwn * kOwn;
  state.covariance(2, 2) = kTurned * kTurned;
  return state;
}

std::vector<Look> survey(int landmarks) {
  const Drive world(landmarks);
  std::vector<Look> looks;
  Se2 map_from_base;
  for (int first = 0; first < landmarks; first += kInView) {
    const int end = std::min(first + kInView, landmarks);
    const Se2 next(world.landmark(first), 0.0);
    Look look{motion(map_from_base.inverse() * next), {}};
    map_from_base = next;
    for (int i = first; i < end; ++i) look.sightings.push_back(sighting(map_from_base, world.landmark(i), i));
    looks.push_back(look);
  }
  looks.push_back({motion(map_from_base.inverse() * world.map_from_base_), {}});
  return looks;
}

}  // namespace kinect_ekf_slam::benchmarks
