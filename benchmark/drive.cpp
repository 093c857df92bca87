#include "benchmark/drive.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam::benchmarks {
namespace {

constexpr double kSpacing = 2.45;  // m between landmarks
constexpr double kStep = 0.022;    // m

template <class Space>
Polar sighting(const typename Space::Pose& map_from_base, const typename Space::Point& landmark,
               int identity) {
  const Eigen::Vector3d point = Space::to_3d(typename Space::Point(map_from_base.inverse() * landmark));
  return {point.norm(), std::atan2(point.y(), point.x()), std::asin(point.z() / point.norm()), identity};
}

template <class Space>
Observation<Space> to_observation(const Polar& polar) {
  Eigen::Matrix3d axes;  // along the ray and across
  axes = Eigen::AngleAxisd(polar.bearing, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(-polar.elevation, Eigen::Vector3d::UnitY());
  const Eigen::Vector3d sigmas(kRangeSigma, polar.range * kBearingSigma, polar.range * kBearingSigma);
  Observation<Space> observation;
  observation.position_in_base = Space::from_3d(Eigen::Vector3d(polar.range * axes.col(0)));
  observation.covariance =
      Space::from_3d(Eigen::Matrix3d(axes * sigmas.cwiseAbs2().asDiagonal() * axes.transpose()));
  observation.signature.source_id = polar.identity;
  return observation;
}

/// Of a motion, by the tangent: a few millimetres and milliradians.
template <class Space>
typename Space::PoseVector motion_sigmas() {
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << 0.002, 0.001, 0.001, 0.001, 0.001, 0.002;
  typename Space::PoseVector of_space;
  for (int i = 0; i < Space::kPoseDim; ++i) of_space(i) = sigmas(Space::kPoseAxes[i]);
  return of_space;
}

template <class Space>
MotionStep<Space> motion(const typename Space::Pose& delta) {
  return {delta, typename Space::PoseMatrix(motion_sigmas<Space>().cwiseAbs2().asDiagonal())};
}

template <class Space>
typename Space::Pose on_the_ground(const Se2& pose) {
  return Space::pose_from_3d(Planar::to_3d(pose));
}

}  // namespace

template <class Space>
std::vector<Observation<Space>> Look<Space>::observations() const {
  std::vector<Observation<Space>> observations;
  for (const Polar& polar : sightings) observations.push_back(to_observation<Space>(polar));
  return observations;
}

template <class Space>
Drive<Space>::Drive(int landmarks) : side_(kSpacing * std::ceil(std::sqrt(landmarks))) {
  std::uniform_real_distribution<double> place(-0.3 * kSpacing, 0.3 * kSpacing);
  std::uniform_real_distribution<double> height(-0.5, 0.5);
  const int in_a_row = static_cast<int>(std::ceil(std::sqrt(landmarks)));
  for (int i = 0; i < landmarks; ++i) {
    const Eigen::Vector3d cell(i % in_a_row + 0.5, i / in_a_row + 0.5, 0.0);
    const Eigen::Vector3d aside(place(random_), place(random_), height(random_));
    landmarks_.push_back(Space::from_3d(Eigen::Vector3d(kSpacing * cell + aside)));
  }
  constexpr double kLane = 5.0;  // m
  const double border = 0.2 * side_;
  bool forth = true;
  for (double y = border; y < side_ - border; y += kLane, forth = !forth) {
    corners_.emplace_back(forth ? border : side_ - border, y);
    corners_.emplace_back(forth ? side_ - border : border, y);
  }
  std::reverse(corners_.begin(), corners_.end());
  map_from_base_ = on_the_ground<Space>(Se2(corners_.back(), 0.0));
}

template <class Space>
Look<Space> Drive<Space>::next() {
  const Eigen::Vector3d corner(corners_.back().x(), corners_.back().y(), 0.0);
  const Eigen::Vector3d ahead = Space::to_3d(Point(map_from_base_.inverse() * Point(Space::from_3d(corner))));
  if (ahead.head<2>().norm() < kStep) std::rotate(corners_.begin(), corners_.end() - 1, corners_.end());
  constexpr double kTurn = 0.1;  // rad
  const double turn = std::clamp(std::atan2(ahead.y(), ahead.x()), -kTurn, kTurn);
  const Pose delta = on_the_ground<Space>(Se2(std::abs(turn) < kTurn ? kStep : 0.0, 0.0, turn));
  Look<Space> look{motion<Space>(delta), {}};
  typename Space::PoseVector slip = motion_sigmas<Space>();
  for (double& each : slip) each = noise(each);
  map_from_base_ = Space::retract(map_from_base_ * delta, slip);

  std::vector<int> nearest(landmarks_.size());
  std::iota(nearest.begin(), nearest.end(), 0);
  const auto distance = [this](int i) { return (landmark(i) - map_from_base_.translation()).squaredNorm(); };
  std::partial_sort(nearest.begin(), nearest.begin() + kInView, nearest.end(),
                    [&](int left, int right) { return distance(left) < distance(right); });
  for (int k = 0; k < kInView; ++k) {
    const int identity = nearest[static_cast<std::size_t>(k)];
    Polar polar = sighting<Space>(map_from_base_, landmark(identity), identity);
    polar.range += noise(kRangeSigma);
    polar.bearing += noise(kBearingSigma);
    if (Space::kPointDim == 3) polar.elevation += noise(kBearingSigma);
    look.sightings.push_back(polar);
  }
  return look;
}

template <class Space>
SlamState<Space> Drive<Space>::known_map() {
  constexpr int kPoseDim = Space::kPoseDim;
  constexpr int kPointDim = Space::kPointDim;
  constexpr double kOwn = 0.03;     // m, of a landmark or the pose
  constexpr double kWhole = 0.1;    // m, where the map lies
  constexpr double kTurned = 0.01;  // rad, of the pose
  const int size = kPoseDim + kPointDim * landmark_count();
  SlamState<Space> state;
  state.map_from_base = map_from_base_;
  state.landmarks_in_map.resize(size - kPoseDim);
  Eigen::Matrix<double, Eigen::Dynamic, kPointDim> shift(size, kPointDim);  // of all by the whole
  shift.setZero();
  shift.template topRows<kPointDim>().diagonal().setConstant(kWhole);
  for (int i = 0; i < landmark_count(); ++i) {
    LandmarkInfo info;
    info.id = info.source_id = i;
    info.observations = 10;
    state.infos.push_back(info);
    Point error;
    for (double& each : error) each = noise(kOwn);
    state.landmarks_in_map.template segment<kPointDim>(kPointDim * i) = landmark(i) + error;
    shift.template middleRows<kPointDim>(kPoseDim + kPointDim * i).diagonal().setConstant(kWhole);
  }
  state.covariance = shift * shift.transpose();
  state.covariance.diagonal().array() += kOwn * kOwn;
  state.covariance.diagonal().template segment<Space::kTurnDim>(kPointDim).setConstant(kTurned * kTurned);
  return state;
}

template <class Space>
std::vector<Look<Space>> survey(int landmarks) {
  const Drive<Space> world(landmarks);
  std::vector<Look<Space>> looks;
  typename Space::Pose map_from_base;
  for (int first = 0; first < landmarks; first += kInView) {
    const int end = std::min(first + kInView, landmarks);
    const Eigen::Vector3d place = Space::to_3d(world.landmark(first));
    const auto next = on_the_ground<Space>(Se2(place.x() + 0.5, place.y(), 0.0));
    Look<Space> look{motion<Space>(map_from_base.inverse() * next), {}};
    map_from_base = next;
    for (int i = first; i < end; ++i) {
      look.sightings.push_back(sighting<Space>(map_from_base, world.landmark(i), i));
    }
    looks.push_back(look);
  }
  looks.push_back({motion<Space>(map_from_base.inverse() * world.map_from_base()), {}});
  return looks;
}

template struct Look<Planar>;
template struct Look<Spatial>;
template class Drive<Planar>;
template class Drive<Spatial>;
template std::vector<Look<Planar>> survey<Planar>(int landmarks);
template std::vector<Look<Spatial>> survey<Spatial>(int landmarks);

}  // namespace kinect_ekf_slam::benchmarks
