#include "kinect_ekf_slam/smoothing/batch.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "kinect_ekf_slam/models/measurement.h"
#include "kinect_ekf_slam/smoothing/errors.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kCovarianceShare = 0.3;  ///< of the time, for the progress
constexpr double kSettled = 0.05;         ///< of a prior's sigma, or of the logarithm of the posterior

/// W with W^T W the inverse of the covariance.
template <class Matrix>
Matrix whitening_of(const Matrix& covariance) {
  const Eigen::LLT<Matrix> root(covariance);
  if (root.info() != Eigen::Success) {
    throw std::runtime_error("a covariance of the run is not positive definite");
  }
  return root.matrixL().solve(Matrix::Identity());
}

template <class Space>
class Batch {
 public:
  static constexpr int kNumbers = Space::kPoseNumbers;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  using PoseMatrix = typename Space::PoseMatrix;

  Batch(const RecordedRun<Space>& run, const BatchOptions& options)
      : run_(run), options_(options), odometry_(run.velocities, options.motion) {
    if (run.path.empty()) throw std::invalid_argument("the run has no path");
    if (run.sightings.empty()) throw std::invalid_argument("the run has no sighting of a landmark");
    place_knots();
    landmarks_ = run.landmarks_in_map;
    calibration_.sensor(kDepthShare) = options.sensor.depth_share;
    std::vector<TimeNs> last_seen(landmarks_.size(), 0);
    for (const RecordedSighting& sighting : run.sightings) {
      TimeNs& last = last_seen[sighting.landmark];
      const double since =
          last == 0 ? std::numeric_limits<double>::infinity() : to_seconds(sighting.stamp - last);
      echo_.push_back(correlation_inflation(since, options.sensor.correlation_time));
      last = sighting.stamp;
      mean_obliquity_ +=
          obliquity(sighting.detection.position_in_optical) / static_cast<double>(run.sightings.size());
    }
  }

  BatchResult<Space> solve() {
    int round = 0;
    bool settled = false;
    while (round < options_.rounds && !settled) {
      // Halfway after the first ones: the velocity's steps could throw the delay to and fro.
      linearized_at_ += (round < 2 ? 1.0 : 0.5) * (calibration_.motion - linearized_at_);
      settled = optimize();
      progress((1.0 - kCovarianceShare) * ++round / options_.rounds);
    }
    linearized_at_ = calibration_.motion;
    build();
    std::vector<typename SmoothedPath<Space>::Knot> knots = covariances();
    BatchResult<Space> result{SmoothedPath<Space>(odometry_, std::move(knots)),
                              std::move(result_landmarks_),
                              calibration_,
                              std::move(calibration_covariance_),
                              outcomes(),
                              cost_,
                              mean_obliquity_,
                              round,
                              settled};
    progress(1.0);
    return result;
  }

 private:
  struct Knot {
    TimeNs stamp;
    std::array<double, kNumbers> numbers;
  };

  void progress(double share) const {
    if (options_.on_progress) options_.on_progress(share);
  }

  void place_knots() {
    std::set<TimeNs> looks;
    for (const RecordedSighting& sighting : run_.sightings) looks.insert(sighting.stamp);
    const TimeNs longest = to_nanoseconds(options_.longest_step);
    for (std::size_t i = 0; i < run_.path.size(); ++i) {
      const TimeNs stamp = run_.path[i].stamp;
      const bool is_end = i == 0 || i + 1 == run_.path.size();
      const bool is_due = !is_end && run_.path[i + 1].stamp - knots_.back().stamp > longest;
      if (!is_end && !is_due && looks.count(stamp) == 0) continue;
      if (!knots_.empty() && stamp <= knots_.back().stamp) continue;
      Knot knot{stamp, {}};
      const Eigen::VectorXd numbers = Space::to_vector(run_.path[i].map_from_base);
      std::copy(numbers.begin(), numbers.end(), knot.numbers.begin());
      knots_.push_back(knot);
    }
  }

  Knot& knot_at(TimeNs stamp) {
    const auto knot = std::lower_bound(knots_.begin(), knots_.end(), stamp,
                                       [](const Knot& k, TimeNs time) { return k.stamp < time; });
    if (knot == knots_.end() || knot->stamp != stamp) {
      throw std::invalid_argument("the run's path has no pose at a sighting's stamp");
    }
    return *knot;
  }

  static Pose pose_of(const Knot& knot) {
    return Space::pose_from_vector(Eigen::Map<const Eigen::VectorXd>(knot.numbers.data(), kNumbers));
  }

  /// One round; true when it changed nothing any more.
  bool optimize() {
    const Calibration<Space> before = calibration_;
    build();
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = 50;
    solver.function_tolerance = 1e-8;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, problem_.get(), &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error(summary.message);
    const double gain = std::abs(cost_ - summary.final_cost);
    cost_ = summary.final_cost;
    const Calibration<Space> sigma = sigmas<Space>(options_.prior);
    const double change =
        std::max((calibration_.motion - before.motion).cwiseQuotient(sigma.motion).cwiseAbs().maxCoeff(),
                 (calibration_.sensor - before.sensor).cwiseQuotient(sigma.sensor).cwiseAbs().maxCoeff());
    return std::min(change, gain) < kSettled && summary.termination_type == ceres::CONVERGENCE;
  }

  void build() {
    problem_ = std::make_unique<ceres::Problem>();
    odometry_.set_calibration(linearized_at_);
    for (Knot& knot : knots_) add_pose_block(knot.numbers.data());
    add_priors();
    for (std::size_t k = 0; k + 1 < knots_.size(); ++k) add_motion(k);
    sighting_errors_.clear();
    for (std::size_t i = 0; i < run_.sightings.size(); ++i) add_sighting(i);
  }

  void add_pose_block(double* numbers) {
    if constexpr (Space::kTurnDim > 1) {
      using Manifold = ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::EigenQuaternionManifold>;
      problem_->AddParameterBlock(numbers, kNumbers, new Manifold);
    } else {
      problem_->AddParameterBlock(numbers, kNumbers);
    }
  }

  void add_priors() {
    const Pose start = run_.path.front().map_from_base;
    const PoseMatrix start_from_map = local_from_error<Space>(start);
    const StartError<Space> error{
        start, whitening_of(PoseMatrix(start_from_map * run_.start_covariance * start_from_map.transpose()))};
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<StartError<Space>, Space::kPoseDim, kNumbers>(
                                   new StartError<Space>(error)),
                               nullptr, knots_.front().numbers.data());
    const Calibration<Space> sigma = sigmas<Space>(options_.prior);
    Calibration<Space> expected;
    expected.sensor(kDepthShare) = options_.sensor.depth_share;
    const auto add = [this](const auto& sigmas, const auto& mean, double* values) {
      const Eigen::MatrixXd information = sigmas.cwiseInverse().asDiagonal();
      problem_->AddResidualBlock(new ceres::NormalPrior(information, mean), nullptr, values);
    };
    add(sigma.motion, expected.motion, calibration_.motion.data());
    add(sigma.sensor, expected.sensor, calibration_.sensor.data());
  }

  void add_motion(std::size_t k) {
    const Increment<Space> increment = odometry_.between(knots_[k].stamp, knots_[k + 1].stamp);
    auto error = std::make_unique<MotionError<Space>>(
        MotionError<Space>{increment, linearized_at_, whitening_of(increment.covariance)});
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<MotionError<Space>, Space::kPoseDim, kNumbers,
                                                               kNumbers, kMotionUnknowns>(error.release()),
                               nullptr, knots_[k].numbers.data(), knots_[k + 1].numbers.data(),
                               calibration_.motion.data());
  }

  void add_sighting(std::size_t i) {
    const RecordedSighting& sighting = run_.sightings[i];
    Knot& knot = knot_at(sighting.stamp);
    Detection corrected = with_range_corrected(sighting.detection, options_.sensor);
    SightingError<Space> error;
    error.obliquity = obliquity(sighting.detection.position_in_optical);
    error.configured_share = options_.sensor.depth_share;
    error.mean_obliquity = mean_obliquity_;
    const Eigen::Vector3d ray = corrected.base_from_optical * corrected.position_in_optical;
    error.seen = Space::from_3d(ray);
    error.sensor = Space::from_3d(Eigen::Vector3d(corrected.position_in_base - ray));
    // Noise of the distance that should have been measured: that of the measured one would favour short ones.
    corrected.position_in_optical *= expected_over_seen(error, knot, sighting.landmark);
    error.whitening = whitening_of(
        typename Space::PointMatrix(Space::from_3d(sighting_covariance(corrected, options_.sensor))));
    sighting_errors_.push_back(error);
    problem_->AddResidualBlock(
        new ceres::AutoDiffCostFunction<SightingError<Space>, Space::kPointDim, kNumbers, Space::kPointDim,
                                        kSensorUnknowns<Space>>(new SightingError<Space>(error)),
        new ceres::ScaledLoss(new ceres::CauchyLoss(options_.loss_scale), 1.0 / echo_[i],
                              ceres::TAKE_OWNERSHIP),
        knot.numbers.data(), landmarks_[sighting.landmark].data(), calibration_.sensor.data());
  }

  double expected_over_seen(const SightingError<Space>& error, const Knot& knot, int landmark) const {
    const Point landmark_in_base = pose_of(knot).inverse() * landmarks_[landmark];
    const double ratio = (landmark_in_base - error.sensor).norm() /
                         (error.factor(calibration_.sensor.data()) * error.seen.norm());
    return std::clamp(ratio, 0.5, 2.0);
  }

  std::vector<SightingOutcome> outcomes() {
    std::vector<SightingOutcome> outcomes;
    for (std::size_t i = 0; i < run_.sightings.size(); ++i) {
      const RecordedSighting& sighting = run_.sightings[i];
      Point residual;
      sighting_errors_[i](knot_at(sighting.stamp).numbers.data(), landmarks_[sighting.landmark].data(),
                          calibration_.sensor.data(), residual.data());
      const double squared = residual.squaredNorm();
      double loss[3];
      ceres::CauchyLoss(options_.loss_scale).Evaluate(squared, loss);
      outcomes.push_back({squared, loss[1]});
    }
    return outcomes;
  }

  /// Covariances of landmarks and calibration, and the knots with theirs.
  std::vector<typename SmoothedPath<Space>::Knot> covariances() {
    double* motion = calibration_.motion.data();
    double* sensor = calibration_.sensor.data();
    std::vector<std::pair<const double*, const double*>> blocks = {
        {motion, motion}, {motion, sensor}, {sensor, sensor}};
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      const double* numbers = knots_[k].numbers.data();
      blocks.emplace_back(numbers, numbers);
      if (k + 1 < knots_.size()) blocks.emplace_back(numbers, knots_[k + 1].numbers.data());
    }
    for (const Point& landmark : landmarks_) {
      if (problem_->HasParameterBlock(landmark.data())) blocks.emplace_back(landmark.data(), landmark.data());
    }
    ceres::Covariance covariance{ceres::Covariance::Options()};
    if (!covariance.Compute(blocks, problem_.get())) {
      throw std::runtime_error("the covariance cannot be computed; the run does not tell all unknowns");
    }
    read_calibration(covariance);
    for (const Point& landmark : landmarks_) {
      typename BatchResult<Space>::Landmark result{landmark, Space::PointMatrix::Identity(), false};
      if (problem_->HasParameterBlock(landmark.data())) {
        result.was_seen = true;
        result.covariance =
            block<Space::kPointDim, Space::kPointDim>(covariance, landmark.data(), landmark.data());
      }
      result_landmarks_.push_back(result);
    }
    std::vector<typename SmoothedPath<Space>::Knot> knots;
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      const double* numbers = knots_[k].numbers.data();
      const PoseMatrix local = local_from_tangent(knots_[k]);
      typename SmoothedPath<Space>::Knot knot{knots_[k].stamp, pose_of(knots_[k])};
      knot.covariance =
          local * block<Space::kPoseDim, Space::kPoseDim>(covariance, numbers, numbers) * local.transpose();
      if (k + 1 < knots_.size()) {
        knot.with_next =
            local *
            block<Space::kPoseDim, Space::kPoseDim>(covariance, numbers, knots_[k + 1].numbers.data()) *
            local_from_tangent(knots_[k + 1]).transpose();
      }
      knots.push_back(knot);
    }
    return knots;
  }

  void read_calibration(const ceres::Covariance& covariance) {
    constexpr int kSensor = kSensorUnknowns<Space>;
    const double* motion = calibration_.motion.data();
    const double* sensor = calibration_.sensor.data();
    Eigen::MatrixXd& joint = calibration_covariance_;
    joint.resize(kMotionUnknowns + kSensor, kMotionUnknowns + kSensor);
    joint.topLeftCorner(kMotionUnknowns, kMotionUnknowns) =
        block<kMotionUnknowns, kMotionUnknowns>(covariance, motion, motion);
    joint.bottomRightCorner(kSensor, kSensor) = block<kSensor, kSensor>(covariance, sensor, sensor);
    joint.topRightCorner(kMotionUnknowns, kSensor) =
        block<kMotionUnknowns, kSensor>(covariance, motion, sensor);
    joint.bottomLeftCorner(kSensor, kMotionUnknowns) =
        joint.topRightCorner(kMotionUnknowns, kSensor).transpose();
  }

  template <int rows, int columns>
  static Eigen::Matrix<double, rows, columns> block(const ceres::Covariance& covariance, const double* first,
                                                    const double* second) {
    Eigen::Matrix<double, rows, columns, Eigen::RowMajor> values;
    covariance.GetCovarianceBlockInTangentSpace(first, second, values.data());
    return values;
  }

  /// Ceres turns a quaternion in the axes of the map, by twice its tangent.
  static PoseMatrix local_from_tangent(const Knot& knot) {
    PoseMatrix matrix = local_from_error<Space>(pose_of(knot));
    if constexpr (Space::kTurnDim > 1) matrix.template rightCols<Space::kTurnDim>() *= 2.0;
    return matrix;
  }

  const RecordedRun<Space>& run_;
  const BatchOptions& options_;
  OdometryTrack<Space> odometry_;
  std::vector<Knot> knots_;
  std::vector<Point> landmarks_;
  Calibration<Space> calibration_;
  MotionCalibration linearized_at_ = MotionCalibration::Zero();
  std::vector<double> echo_;  ///< how much less a sighting tells because of the one before
  std::vector<SightingError<Space>> sighting_errors_;
  std::unique_ptr<ceres::Problem> problem_;
  double mean_obliquity_ = 0.0;
  double cost_ = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd calibration_covariance_;
  std::vector<typename BatchResult<Space>::Landmark> result_landmarks_;
};

}  // namespace

template <class Space>
BatchResult<Space> batch_optimum(const RecordedRun<Space>& run, const BatchOptions& options) {
  return Batch<Space>(run, options).solve();
}

template BatchResult<Planar> batch_optimum<Planar>(const RecordedRun<Planar>&, const BatchOptions&);
template BatchResult<Spatial> batch_optimum<Spatial>(const RecordedRun<Spatial>&, const BatchOptions&);

}  // namespace kinect_ekf_slam
