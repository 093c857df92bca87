#include "kinect_ekf_slam/study/buoy_world.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kLong = 16.0;  // m, half axes of the way
constexpr double kShort = 10.0;
constexpr double kDepth = 1.5;       // m, by which it climbs and dives
constexpr int kPatches = 4;          // where there is something to see
constexpr double kPatchShare = 0.6;  // of the way
constexpr int kPerPatch = 14;        // landmarks

template <int Size>
Eigen::Matrix<double, Size, 1> normal(RandomStream* random) {
  return Eigen::Matrix<double, Size, 1>::NullaryExpr([&] { return random->normal(); });
}

/// Place on the way by the ellipse's parameter.
Eigen::Vector3d way_at(double phase) {
  return {kLong * std::cos(phase), kShort * std::sin(phase), kDepth * std::sin(2.0 * phase) - 6.0};
}

/// The parameter by the distance driven, in a table.
class ArcLength {
 public:
  ArcLength() : lengths_(kIntervals + 1, 0.0) {
    for (int i = 1; i <= kIntervals; ++i) {
      lengths_[i] = lengths_[i - 1] + (way_at(phase(i)) - way_at(phase(i - 1))).norm();
    }
  }
  double length() const { return lengths_.back(); }
  double phase_after(double distance) const {
    const double rest = distance - length() * std::floor(distance / length());
    const auto above = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, rest);
    const int i = static_cast<int>(above - lengths_.begin());
    return phase(i - 1) + (phase(i) - phase(i - 1)) * (rest - *(above - 1)) / (*above - *(above - 1));
  }

 private:
  static constexpr int kIntervals = 20000;
  static double phase(int i) { return 2.0 * kPi * i / kIntervals; }
  std::vector<double> lengths_;
};

const ArcLength& arc_length() {
  static const ArcLength table;
  return table;
}

}  // namespace

BuoyWorld::BuoyWorld(const BuoyScenario& scenario, std::uint64_t seed)
    : scenario_(scenario), odometry_random_(seed, 0), sensor_random_(seed, 1), beacon_random_(seed, 2) {
  const double dt = 1.0 / scenario.rate;
  odometry_sigma_ << Eigen::Vector3d::Constant(scenario.linear_sigma * dt),
      Eigen::Vector3d::Constant(radians(scenario.angular_sigma_deg) * dt);
  place_landmarks(seed);
  // Buoys on the surface and on the ground by turns, so that they span space.
  for (int i = 0; i < 6; ++i) {
    const int row = i / 2 - 1;
    const Eigen::Vector3d place(30.0 * row, i % 2 == 0 ? -25.0 : 25.0, (i / 2 + i) % 2 == 0 ? 0.0 : -20.0);
    beacons_[i] = {place, Eigen::Matrix3d::Identity() * 1e-8};
  }
}

/// Along each patch, no two so near that one could be the other.
void BuoyWorld::place_landmarks(std::uint64_t seed) {
  constexpr double kApart = 1.2;  // m
  RandomStream places(seed, 3);
  for (int patch = 0; patch < kPatches; ++patch) {
    for (int i = 0; i < kPerPatch;) {
      const double share = (patch + kPatchShare * i / (kPerPatch - 1)) / kPatches;
      const double right =
          places.uniform(-2.0, 2.0);  // one after the other: the order of arguments is not defined
      const double ahead = places.uniform(-2.0, 2.0);
      const double up = places.uniform(-1.0, 1.0);
      const Eigen::Vector3d place = way_point(share * way_length()) + Eigen::Vector3d(right, ahead, up);
      const bool is_free =
          std::all_of(landmarks_.begin(), landmarks_.end(),
                      [&](const Eigen::Vector3d& other) { return (other - place).norm() >= kApart; });
      if (!is_free) continue;
      landmarks_.push_back(place);
      ++i;
    }
  }
}

double BuoyWorld::way_length() { return arc_length().length(); }

Eigen::Vector3d BuoyWorld::way_point(double distance) { return way_at(arc_length().phase_after(distance)); }

int BuoyWorld::steps() const {
  return static_cast<int>(scenario_.rounds * way_length() * scenario_.rate / scenario_.speed);
}

/// Forward along the way, banking into its bends.
Se3 BuoyWorld::true_pose(int step) const {
  constexpr double kSmall = 0.05;  // m
  const double distance = step * scenario_.speed / scenario_.rate;
  const Eigen::Vector3d ahead = (way_point(distance + kSmall) - way_point(distance - kSmall)).normalized();
  const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(ahead).normalized();
  Eigen::Matrix3d attitude;
  attitude << ahead, left, ahead.cross(left);
  const double bank = 0.2 * std::sin(3.0 * arc_length().phase_after(distance));
  attitude = attitude * Eigen::AngleAxisd(bank, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return {way_point(distance), Eigen::Quaterniond(attitude)};
}

MotionStep<Spatial> BuoyWorld::drive(int step) {
  MotionStep<Spatial> motion;
  const Spatial::PoseVector error = odometry_sigma_.cwiseProduct(normal<6>(&odometry_random_));
  motion.delta = true_pose(step - 1).inverse() * true_pose(step) * Se3::exp(-error);
  motion.covariance = odometry_sigma_.cwiseAbs2().asDiagonal();
  return motion;
}

std::vector<Observation<Spatial>> BuoyWorld::look(int step) {
  // Optical axes in those of the base: Z forward, X right, Y down.
  const Eigen::Matrix3d base_from_optical = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
  const Se3 base_from_world = true_pose(step).inverse();
  std::vector<Observation<Spatial>> observations;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    Detection detection;
    detection.base_from_optical = base_from_optical;
    detection.position_in_base = base_from_world * landmarks_[i];
    detection.position_in_optical = base_from_optical.transpose() * detection.position_in_base;
    if (!sees(detection)) continue;
    Observation<Spatial> observation;
    observation.covariance = with_noise(detection, scenario_.sensor).covariance_in_base;
    observation.position_in_base =
        detection.position_in_base + observation.covariance.llt().matrixL() * normal<3>(&sensor_random_);
    observation.signature.source_id = static_cast<int>(i);
    observations.push_back(observation);
  }
  return observations;
}

bool BuoyWorld::sees(const Detection& detection) const {
  const Eigen::Vector3d& point = detection.position_in_optical;
  const auto inside = [&](double aside, double angle_deg) {
    return std::abs(aside) <= std::tan(0.5 * radians(angle_deg)) * point.z();
  };
  return in_range(detection, scenario_.sensor) && inside(point.x(), scenario_.field_of_view_deg) &&
         inside(point.y(), scenario_.vertical_field_of_view_deg);
}

std::vector<BeaconRange> BuoyWorld::listen(int step) {
  std::vector<BeaconRange> ranges;
  const int period = std::max(1, static_cast<int>(std::lround(scenario_.beacon_period * scenario_.rate)));
  if (step % period != 0) return ranges;
  for (const auto& [id, beacon] : beacons_) {
    BeaconRange range;
    range.beacon = id;
    range.range = (beacon.mean - true_pose(step).translation()).norm() +
                  scenario_.beacon_sigma * beacon_random_.normal();
    range.variance = scenario_.beacon_sigma * scenario_.beacon_sigma;
    ranges.push_back(range);
  }
  return ranges;
}

}  // namespace kinect_ekf_slam
