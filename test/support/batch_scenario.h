#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/smoothing/batch.h"
#include "kinect_ekf_slam/smoothing/errors.h"

namespace kinect_ekf_slam::testing {

/// A robot that drives loops among landmarks, its odometry and sensor off by a calibration that the
/// configuration does not know; all errors as large as the options say.
template <class Space>
class BatchScenario {
 public:
  using Pose = typename Space::Pose;
  using PoseVector = typename Space::PoseVector;
  static constexpr int kSteps = 400;
  static constexpr double kStep = 0.1;  // s
  static constexpr int kStepsPerLook = 3;

  explicit BatchScenario(std::uint64_t seed) : random_(seed, 1) {
    options.sensor.model = SensorOptions::Model::kRangeBearing;
    options.sensor.range_noise = 0.02;
    options.sensor.range_noise_per_meter = 0.01;
    options.sensor.bearing_noise_deg = 1.0;
    options.motion.angular_noise = 0.02;
    options.prior.depth_share = 0.2;  // shares far below zero are none
    options.loss_scale = 1e3;         // errors are normal: every one counts in full
    draw_calibration();
    place_landmarks();
    drive();
    look();
    guess();
  }

  RecordedRun<Space> run;
  BatchOptions options;
  Calibration<Space> calibration;  ///< the true one
  std::vector<RecordedPose<Space>> path;
  std::vector<typename Space::Point> landmarks;

 private:
  template <class Vector>
  Vector normal(const Vector& sigmas) {
    Vector noise = sigmas;
    for (double& value : noise) value *= random_.normal();
    return noise;
  }

  void draw_calibration() {
    const Calibration<Space> sigma = sigmas<Space>(options.prior);
    calibration.motion = normal(sigma.motion);
    calibration.sensor = normal(sigma.sensor);
  }

  void place_landmarks() {
    for (int i = 0; i < 12; ++i) {
      const double angle = 2.0 * kPi * i / 12.0;
      const double radius = i % 2 == 0 ? 1.5 : 4.5;
      landmarks.push_back(Space::from_3d(Eigen::Vector3d(
          radius * std::cos(angle), 3.0 + radius * std::sin(angle), 0.4 * std::sin(5.0 * i))));
    }
  }

  /// A loop about (0, 3, 0), slower and faster.
  void drive() {
    for (int k = 0; k <= kSteps; ++k) {
      BodyVelocity velocity;
      velocity.linear.x() = 0.5 + 0.1 * std::sin(0.05 * k);
      velocity.angular.z() = velocity.linear.x() / 3.0 * (1.0 + 0.8 * std::cos(0.11 * k));
      run.velocities.push_back({stamp(k), velocity, 1.0});
    }
    OdometryTrack<Space> odometry(run.velocities, options.motion);
    odometry.set_calibration(calibration.motion);
    path.push_back({stamp(0), Pose()});
    for (int k = 1; k <= kSteps; ++k) {
      const Increment<Space> step = odometry.between(stamp(k - 1), stamp(k));
      const typename Space::PoseMatrix root =
          Eigen::LLT<typename Space::PoseMatrix>(step.covariance).matrixL();
      const PoseVector noise = root * normal(PoseVector(PoseVector::Ones()));
      path.push_back({stamp(k), path.back().map_from_base * step.delta * Pose::exp(noise)});
    }
  }

  void look() {
    const Eigen::Vector3d sensor_in_base(0.1, 0.0, 0.3);
    Eigen::Matrix3d base_from_optical;
    base_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    // Twice: the scale is that of the run's mean sighting, which is known only then.
    double mean_obliquity = 0.05;
    for (int pass = 0; pass < 2; ++pass) {
      run.sightings.clear();
      double sum = 0.0;
      for (int k = 0; k <= kSteps; k += kStepsPerLook) {
        for (std::size_t i = 0; i < landmarks.size(); ++i) {
          Detection detection;
          detection.base_from_optical = base_from_optical;
          if (!see(k, i, sensor_in_base, mean_obliquity, &detection)) continue;
          sum += obliquity(detection.position_in_optical);
          run.sightings.push_back({stamp(k), detection, static_cast<int>(i)});
        }
      }
      mean_obliquity = sum / static_cast<double>(run.sightings.size());
    }
  }

  bool see(int k, std::size_t i, const Eigen::Vector3d& sensor_in_base, double mean_obliquity,
           Detection* detection) {
    const PoseVector mounting = calibration.sensor.template tail<Space::kPoseDim>();
    Pose base_from_base_of_sensor = Space::retract(Pose(), mounting);
    const typename Space::Point in_base = path[k].map_from_base.inverse() * landmarks[i];
    const typename Space::Point true_ray =
        base_from_base_of_sensor.inverse() * typename Space::Point(in_base - Space::from_3d(sensor_in_base));
    Eigen::Vector3d ray = Space::to_3d(true_ray);
    if (ray.x() < 0.5 || ray.norm() > 6.0 || std::abs(ray.y()) > 1.7 * ray.x() || std::abs(ray.z()) > ray.x())
      return false;
    const double across = radians(options.sensor.bearing_noise_deg);
    Eigen::Vector3d direction = ray.normalized();
    Eigen::Vector3d aside = Eigen::Vector3d::UnitZ().cross(direction).normalized();
    Eigen::Vector3d turn = across * random_.normal() * aside;
    if (Space::kPointDim == 3) turn += across * random_.normal() * direction.cross(aside);
    direction = (direction + turn).normalized();
    SightingError<Space> model;
    model.obliquity = obliquity(detection->base_from_optical.transpose() * direction);
    model.mean_obliquity = mean_obliquity;
    const double measured = ray.norm() / model.factor(calibration.sensor.data());
    const double sigma =
        std::hypot(options.sensor.range_noise, options.sensor.range_noise_per_meter * measured);
    const Eigen::Vector3d seen = (measured + sigma * random_.normal()) * direction;
    detection->position_in_base = sensor_in_base + seen;
    detection->position_in_optical = detection->base_from_optical.transpose() * seen;
    return true;
  }

  /// Where a filter might have left it all.
  void guess() {
    const PoseVector start_sigma = PoseVector::Constant(0.01);
    run.start_covariance = start_sigma.cwiseAbs2().asDiagonal();
    run.path = path;
    for (RecordedPose<Space>& pose : run.path) {
      pose.map_from_base = pose.map_from_base * Pose::exp(normal(PoseVector(PoseVector::Constant(0.03))));
    }
    run.path.front().map_from_base = path.front().map_from_base * Pose::exp(normal(start_sigma));
    for (const auto& landmark : landmarks) {
      run.landmarks_in_map.push_back(landmark + normal(typename Space::Point(Space::Point::Constant(0.1))));
    }
  }

  static TimeNs stamp(int step) { return to_nanoseconds(100.0 + kStep * step); }

  RandomStream random_;
};

}  // namespace kinect_ekf_slam::testing
