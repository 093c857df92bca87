#include "kinect_ekf_slam/study/consistency_study.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/estimators/factory.h"
#include "kinect_ekf_slam/study/text.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kStep = 1.0;  // s between the times at which errors are noted

/// The closed way: a rectangle with round corners in the middle of the room.
class Way {
 public:
  explicit Way(bool climbs) : climbs_(climbs) {}
  static double length() { return 2.0 * (kLong + kShort) + 2.0 * kPi * kRadius; }

  /// Pose of the robot after `distance` m.
  Eigen::Isometry3d pose(double distance) const {
    constexpr double kSmall = 1e-4;
    const Eigen::Vector3d ahead = (point(distance + kSmall) - point(distance - kSmall)).normalized();
    const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(ahead).normalized();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = point(distance);
    pose.linear() << ahead, left, ahead.cross(left);
    if (climbs_)
      pose.rotate(Eigen::AngleAxisd(0.2 * std::sin(3.0 * phase(distance)), Eigen::Vector3d::UnitX()));
    return pose;
  }

 private:
  static constexpr double kLong = 5.0;    // m, straight
  static constexpr double kShort = 3.0;   // m, straight
  static constexpr double kRadius = 1.0;  // m

  static double phase(double distance) { return 2.0 * kPi * distance / length(); }

  Eigen::Vector3d point(double distance) const {
    double left = distance - length() * std::floor(distance / length());
    Planar::Pose pose(2.5, 1.5, 0.0);
    for (int side = 0; side < 4; ++side) {
      for (const auto& [piece, curvature] :
           {std::pair(side % 2 == 0 ? kLong : kShort, 0.0), std::pair(0.5 * kPi * kRadius, 1.0 / kRadius)}) {
        const double driven = std::min(left, piece);
        pose = pose * Se2::exp({driven, 0.0, driven * curvature});
        left -= driven;
      }
    }
    const double height = climbs_ ? 1.0 + 0.4 * std::sin(2.0 * phase(distance)) : 0.0;
    return {pose.translation().x(), pose.translation().y(), height};
  }

  bool climbs_;
};

/// Where the landmarks stand: along the way, by turns outside and inside of it, at all heights.
template <class Space>
std::vector<typename Space::Point> place_landmarks(const Way& way) {
  constexpr int kLandmarks = 18;
  std::vector<typename Space::Point> landmarks;
  for (int i = 0; i < kLandmarks; ++i) {
    const Eigen::Isometry3d pose = way.pose(Way::length() * i / kLandmarks);
    Eigen::Vector3d point = pose * Eigen::Vector3d(0.0, i % 2 == 0 ? -0.9 : 0.9, 0.0);
    point.z() += 0.25 * (i % 3 - 1);
    landmarks.push_back(Space::from_3d(point));
  }
  return landmarks;
}

/// One run of one estimator.
struct Run {
  std::vector<double> nees;
  double squared_position = 0.0;
  double squared_rotation = 0.0;
  double squared_landmarks = 0.0;
  std::vector<std::vector<double>> error;
  std::vector<std::vector<double>> sigma;
};

template <class Space>
class World {
 public:
  using Pose = typename Space::Pose;
  using PoseVector = typename Space::PoseVector;

  World(const ConsistencyScenario& scenario, std::uint64_t seed)
      : scenario_(scenario),
        way_(Space::kPointDim == 3),
        landmarks_(place_landmarks<Space>(way_)),
        odometry_random_(seed, 0),
        sensor_random_(seed, 1) {
    const double dt = 1.0 / scenario.rate;
    noise_.setZero();
    noise_(0) = scenario.linear_sigma * dt;
    noise_.template tail<Space::kTurnDim>().setConstant(radians(scenario.angular_sigma_deg) * dt);
  }

  Pose true_pose(int step) const {
    return Space::pose_from_3d(way_.pose(step * scenario_.speed / scenario_.rate));
  }
  int steps() const {
    return static_cast<int>(scenario_.loops * Way::length() * scenario_.rate / scenario_.speed);
  }

  /// What the odometry says of the way from `step` - 1 to `step`.
  MotionStep<Space> drive(int step) {
    MotionStep<Space> motion;
    const PoseVector error = noise_.cwiseProduct(normal<Space::kPoseDim>(&odometry_random_));
    motion.delta = true_pose(step - 1).inverse() * true_pose(step) * Pose::exp(-error);
    motion.covariance = noise_.cwiseAbs2().asDiagonal();
    return motion;
  }

  std::vector<Observation<Space>> look(int step) {
    // Optical axes in those of the base: Z forward, X right, Y down.
    const Eigen::Matrix3d base_from_optical = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
    std::vector<Observation<Space>> observations;
    const Pose base_from_map = true_pose(step).inverse();
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      Detection detection;
      detection.base_from_optical = base_from_optical;
      detection.position_in_base = Space::to_3d(base_from_map * landmarks_[i]);
      detection.position_in_optical = base_from_optical.transpose() * detection.position_in_base;
      if (!sees(detection)) continue;
      const Detection modelled = with_noise(detection, scenario_.sensor);
      Observation<Space> observation;
      observation.covariance = Space::from_3d(modelled.covariance_in_base);
      observation.position_in_base =
          Space::from_3d(detection.position_in_base) +
          observation.covariance.llt().matrixL() * normal<Space::kPointDim>(&sensor_random_);
      observation.signature.source_id = static_cast<int>(i);
      observations.push_back(observation);
    }
    return observations;
  }

  PoseEstimate<Space> start() {
    PoseEstimate<Space> start;
    start.covariance.diagonal().setConstant(1e-8);  // m^2, rad^2: the map's frame is the start's
    start.map_from_base = true_pose(0);
    return start;
  }
  const std::vector<typename Space::Point>& landmarks() const { return landmarks_; }

 private:
  bool sees(const Detection& detection) const {
    const Eigen::Vector3d& point = detection.position_in_optical;
    const auto inside = [&](double aside, double angle_deg) {
      return std::abs(aside) <= std::tan(0.5 * radians(angle_deg)) * point.z();
    };
    return in_range(detection, scenario_.sensor) && inside(point.x(), scenario_.field_of_view_deg) &&
           inside(point.y(), scenario_.vertical_field_of_view_deg);
  }
  template <int Size>
  static Eigen::Matrix<double, Size, 1> normal(RandomStream* random) {
    return Eigen::Matrix<double, Size, 1>::NullaryExpr([&] { return random->normal(); });
  }

  ConsistencyScenario scenario_;
  Way way_;
  std::vector<typename Space::Point> landmarks_;
  RandomStream odometry_random_;
  RandomStream sensor_random_;
  PoseVector noise_;  // sigma of each step
};

/// The filter as the textbook has it: no precaution against what does not happen here.
EstimatorOptions textbook(EstimatorOptions::Type type) {
  EstimatorOptions options;
  options.type = type;
  options.robust_threshold = 0.0;
  options.replace_after = 0;
  return options;
}

template <class Space>
Run run_once(const ConsistencyScenario& scenario, EstimatorOptions::Type type, std::uint64_t seed,
             bool keeps_errors) {
  World<Space> world(scenario, seed);
  AssociationOptions association;
  association.type = AssociationOptions::Type::kKnown;
  association.gate_probability = 1.0 - 1e-9;
  const auto estimator = make_estimator<Space>(textbook(type), association, world.start());
  const int noted_every = static_cast<int>(kStep * scenario.rate);
  Run run;
  for (int step = 1; step <= world.steps(); ++step) {
    estimator->predict(world.drive(step));
    const auto observations = world.look(step);
    if (!observations.empty()) estimator->observe(to_nanoseconds(step / scenario.rate), observations);
    if (step % noted_every != 0) continue;
    const PoseEstimate<Space> pose = estimator->pose();
    const auto error = pose_error<Space>(pose.map_from_base, world.true_pose(step));
    run.nees.push_back(error.dot(pose.covariance.ldlt().solve(error)));
    run.squared_position += error.template head<Space::kPointDim>().squaredNorm();
    run.squared_rotation += error.template tail<Space::kTurnDim>().squaredNorm();
    if (!keeps_errors) continue;
    const std::array<int, 3> shown = {0, 1, Space::kPoseDim - 1};
    run.error.emplace_back();
    run.sigma.emplace_back();
    for (const int axis : shown) {
      run.error.back().push_back(error(axis));
      run.sigma.back().push_back(std::sqrt(pose.covariance(axis, axis)));
    }
  }
  const auto landmarks = estimator->landmarks();
  for (const LandmarkEstimate<Space>& landmark : landmarks) {
    run.squared_landmarks +=
        (landmark.position_in_map - world.landmarks()[landmark.info.source_id]).squaredNorm() /
        static_cast<double>(landmarks.size());
  }
  return run;
}

const char* name_of(EstimatorOptions::Type type) {
  for (const EstimatorName& estimator : kEstimators) {
    if (estimator.type == type) return estimator.name;
  }
  return "unknown";
}

}  // namespace

template <class Space>
std::vector<ConsistencyResult> run_consistency(const ConsistencyScenario& scenario,
                                               const std::vector<EstimatorOptions::Type>& estimators,
                                               int seeds, const std::function<void(double)>& on_progress) {
  const auto seed_count = static_cast<std::size_t>(seeds);
  std::vector<Run> runs(estimators.size() * seed_count);
  for_each_run(
      runs.size(),
      [&](std::size_t i) {
        const std::size_t seed = i % seed_count;
        runs[i] = run_once<Space>(scenario, estimators[i / seed_count], seed + 1, seed == 0);
      },
      on_progress);

  std::vector<ConsistencyResult> results;
  for (std::size_t estimator = 0; estimator < estimators.size(); ++estimator) {
    ConsistencyResult result;
    result.estimator = name_of(estimators[estimator]);
    std::vector<std::vector<double>> nees;
    for (std::size_t seed = 0; seed < seed_count; ++seed) {
      const Run& run = runs[estimator * seed_count + seed];
      const double weight = 1.0 / static_cast<double>(seed_count * run.nees.size());
      result.position_rmse += weight * run.squared_position;
      result.rotation_rmse += weight * run.squared_rotation;
      result.landmark_rmse += run.squared_landmarks / static_cast<double>(seed_count);
      nees.push_back(run.nees);
    }
    result.position_rmse = std::sqrt(result.position_rmse);
    result.rotation_rmse = std::sqrt(result.rotation_rmse);
    result.landmark_rmse = std::sqrt(result.landmark_rmse);
    result.pose = consistency(nees, Space::kPoseDim);
    result.example_error = runs[estimator * seed_count].error;
    result.example_sigma = runs[estimator * seed_count].sigma;
    results.push_back(std::move(result));
  }
  return results;
}

std::string to_table(const std::vector<ConsistencyResult>& results) {
  std::string table = format("%-16s %10s %20s %13s %15s %13s\n", "estimator", "mean NEES",
                             "inside 95 % bounds", "position (m)", "rotation (deg)", "landmarks (m)");
  for (const ConsistencyResult& result : results) {
    table += format("%-16s %10.2f %18.0f %% %13.3f %15.2f %13.3f\n", result.estimator.c_str(),
                    result.pose.mean, 100.0 * result.pose.inside_share, result.position_rmse,
                    degrees(result.rotation_rmse), result.landmark_rmse);
  }
  const Consistency& bounds = results.front().pose;
  return table + format("bounds of the NEES averaged over the runs: %.2f to %.2f\n", bounds.low, bounds.high);
}

std::string to_json(const std::vector<ConsistencyResult>& results) {
  std::string text = "[\n";
  for (const ConsistencyResult& result : results) {
    text += std::string(text.size() > 2 ? ",\n" : "") + "{\"estimator\": \"" + result.estimator +
            "\", \"pose_nees\": " + number(result.pose.mean) +
            ", \"pose_nees_bounds\": " + json(std::vector<double>{result.pose.low, result.pose.high}) +
            ", \"pose_nees_inside_share\": " + number(result.pose.inside_share) +
            ", \"position_rmse_m\": " + number(result.position_rmse) +
            ", \"rotation_rmse_rad\": " + number(result.rotation_rmse) +
            ", \"landmark_rmse_m\": " + number(result.landmark_rmse) +
            ",\n \"time_step_s\": " + number(kStep) +
            ",\n \"nees_over_time\": " + json(result.pose.mean_nees) +
            ",\n \"example_error\": " + json(result.example_error) +
            ",\n \"example_sigma\": " + json(result.example_sigma) + "}";
  }
  return text + "\n]\n";
}

template std::vector<ConsistencyResult> run_consistency<Planar>(const ConsistencyScenario&,
                                                                const std::vector<EstimatorOptions::Type>&,
                                                                int, const std::function<void(double)>&);
template std::vector<ConsistencyResult> run_consistency<Spatial>(const ConsistencyScenario&,
                                                                 const std::vector<EstimatorOptions::Type>&,
                                                                 int, const std::function<void(double)>&);

}  // namespace kinect_ekf_slam
