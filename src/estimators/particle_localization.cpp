#include "kinect_ekf_slam/estimators/particle_localization.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/estimators/gaussian.h"
#include "kinect_ekf_slam/estimators/particles.h"

namespace kinect_ekf_slam {
namespace {

constexpr std::uint32_t kSearchStream = 0;  // of random numbers
constexpr std::uint32_t kPictureStream = 1;

// A sighting is what it seems with probability 0.95; else it is anything, anywhere in some 5 m^2.
constexpr double kFalseDensity = 0.05 / 5.0;  // 1/m^2
// Labels and radii may be misread: they never exclude a landmark by themselves.
constexpr double kMisreading = 0.05;
constexpr double kRadiusSigma = 0.02;  // m

// Evidence of the same place counts once: sightings are used again when the robot has gone or turned so far.
constexpr double kTravel = 0.05;        // m
constexpr double kTurn = radians(5.0);  // rad
constexpr double kRoughening = 0.01;    // m; particles that are copies of each other part by so much a time
constexpr double kTurnRoughening = radians(0.5);

// When the particles are one cluster.
constexpr double kClusterRadius = 0.5;  // m
constexpr double kClusterTurn = radians(20.0);
constexpr double kOtherWeight = 1e-3;   // that particles elsewhere may hold
constexpr double kLargestSigma = 0.04;  // m
constexpr double kLargestTurnSigma = radians(2.0);
constexpr std::size_t kFramesOfNothing = 20;  // most of which nothing explains: begin again

// When a pose is certain: it explains the last sightings as one rigid picture, and no other pose does.
constexpr std::size_t kSightings = 30;
constexpr std::size_t kNewSightings = 10;  // before the question is asked again
constexpr double kExplainedShare = 0.9;
constexpr double kExplainedDistance = 13.8;  // squared; 0.999 of the true sightings in the plane
constexpr std::size_t kLandmarks = 4;        // different ones
constexpr double kMargin = 10.0;             // of the log-likelihood, to any pose elsewhere
constexpr double kDrift = 0.03;              // m; of the odometry within the picture

/// How much a landmark's looks speak against it: one, nothing does.
double resemblance(const LandmarkInfo& info, const Signature& signature) {
  double likeness = 1.0;
  const std::string label = info.label();
  if (!label.empty() && !signature.label.empty() && label != signature.label) likeness *= kMisreading;
  if (info.radius > 0.0 && signature.radius > 0.0) {
    const double difference = (info.radius - signature.radius) / kRadiusSigma;
    likeness *= std::max(kMisreading, std::exp(-0.5 * difference * difference));
  }
  return likeness;
}

template <class Space>
bool is_near(const typename Space::Pose& from, const typename Space::Pose& to, double distance,
             double angle) {
  const typename Space::PoseVector difference = local_difference<Space>(from, to);
  constexpr int kTurns = Space::kPoseDim - Space::kPointDim;
  return difference.template head<Space::kPointDim>().norm() < distance &&
         difference.template tail<kTurns>().norm() < angle;
}

template <class Space>
typename Space::PoseVector sigmas(double position, double rotation) {
  typename Space::PoseVector sigmas = Space::PoseVector::Constant(rotation);
  sigmas.template head<Space::kPointDim>().setConstant(position);
  return sigmas;
}

struct Match {
  int landmark = -1;  ///< index in the map; none: all are out of the question
  double squared_distance = 0.0;
  double log_likelihood = 0.0;
};

/// The landmark that explains a sighting best from a pose.
template <class Space>
Match best_match(const LandmarkMap<Space>& map, const typename Space::Pose& map_from_base,
                 const Observation<Space>& observation) {
  constexpr double kFar = 1.0;  // m; no landmark so far off is worth the computation
  Match best;
  double density = 0.0;
  const auto seen_in_map = map_from_base * observation.position_in_base;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if ((map[i].position_in_map - seen_in_map).squaredNorm() > kFar * kFar) continue;
    const PredictedPoint<Space> point = predict_point<Space>(map_from_base, map[i].position_in_map);
    const auto fit = fit_of<Space::kPointDim>(
        observation.position_in_base - point.point_in_base,
        point.by_landmark * map[i].covariance * point.by_landmark.transpose() + observation.covariance);
    if (!fit) continue;
    const double candidate = resemblance(map[i].info, observation.signature) * std::exp(fit->log_likelihood);
    if (candidate <= density) continue;
    density = candidate;
    best.landmark = static_cast<int>(i);
    best.squared_distance = fit->squared_distance;
  }
  best.log_likelihood = std::log(density + kFalseDensity);
  return best;
}

/// Where the robot can be that sees `observation`: that is any landmark, and the robot may be turned anyhow.
template <class Space>
std::vector<typename Space::Pose> poses_that_see(const LandmarkMap<Space>& map,
                                                 const Observation<Space>& observation, int headings,
                                                 RandomStream* random) {
  using Point = typename Space::Point;
  const typename Space::PointMatrix root = covariance_root(observation.covariance);
  std::vector<typename Space::Pose> poses;
  for (const LandmarkEstimate<Space>& landmark : map) {
    for (int i = 0; i < headings; ++i) {
      typename Space::PoseVector turn = Space::PoseVector::Zero();
      turn(Space::kPoseDim - 1) = 2.0 * kPi * (i + random->uniform(0.0, 1.0)) / headings;
      const auto turned = Space::Pose::exp(turn);
      const Point noise = root * Point::NullaryExpr([&] { return random->normal(); });
      typename Space::PoseVector local = Space::PoseVector::Zero();
      local.template head<Space::kPointDim>() =
          turned.rotation().transpose() * landmark.position_in_map - observation.position_in_base + noise;
      poses.push_back(Space::retract(turned, local));
    }
  }
  return poses;
}

}  // namespace

template <class Space>
ParticleSearch<Space>::ParticleSearch(const LocalizationOptions& options)
    : options_(options), random_(static_cast<std::uint64_t>(options.seed), kSearchStream) {}

template <class Space>
void ParticleSearch<Space>::update(const LandmarkMap<Space>& map, const MotionStep<Space>& motion,
                                   const Observations& observations) {
  if (observations.empty() || map.empty()) return;
  if (poses_.empty()) {
    seed(map, observations);
  } else {
    move(motion);
  }
  std::vector<double> log_weights(poses_.size());
  for (std::size_t m = 0; m < poses_.size(); ++m) {
    log_weights[m] = std::log(weights_[m]);
    for (const Observation<Space>& observation : observations) {
      log_weights[m] += best_match<Space>(map, poses_[m], observation).log_likelihood;
    }
  }
  if (is_hopeless(log_weights, observations.size())) return begin_again();
  weights_ = normalized_weights(log_weights);
  if (effective_sample_size(weights_) < 0.5 * static_cast<double>(weights_.size())) resample();
}

template <class Space>
void ParticleSearch<Space>::begin_again() {
  poses_.clear();
  supported_.clear();
}

/// No particle has much to say to most of what was seen: the search began with a sighting of nothing.
template <class Space>
bool ParticleSearch<Space>::is_hopeless(const std::vector<double>& log_weights, std::size_t sightings) {
  double density = 0.0;
  for (const double log_weight : log_weights) density += std::exp(log_weight);
  supported_.push_back(density > std::pow(2.0 * kFalseDensity, static_cast<double>(sightings)));
  if (supported_.size() > kFramesOfNothing) supported_.pop_front();
  const auto unsupported = std::count(supported_.begin(), supported_.end(), false);
  return unsupported > static_cast<std::ptrdiff_t>(kFramesOfNothing / 2);
}

template <class Space>
void ParticleSearch<Space>::seed(const LandmarkMap<Space>& map, const Observations& observations) {
  const auto nearest = std::min_element(
      observations.begin(), observations.end(),
      [](const auto& a, const auto& b) { return a.position_in_base.norm() < b.position_in_base.norm(); });
  constexpr int kFewestHeadings = 72;
  const int headings = std::max(kFewestHeadings, options_.max_particles / static_cast<int>(map.size()));
  poses_ = poses_that_see<Space>(map, *nearest, headings, &random_);
  weights_.assign(poses_.size(), 1.0 / static_cast<double>(poses_.size()));
}

template <class Space>
void ParticleSearch<Space>::move(const MotionStep<Space>& motion) {
  const typename Space::PoseMatrix roughening =
      sigmas<Space>(kRoughening, kTurnRoughening).cwiseAbs2().asDiagonal();
  const typename Space::PoseMatrix root =
      covariance_root<typename Space::PoseMatrix>(motion.covariance + roughening);
  const Eigen::MatrixXd white =
      standardized_draws(Space::kPoseDim, static_cast<int>(poses_.size()), &random_);
  for (std::size_t m = 0; m < poses_.size(); ++m) {
    const typename Space::PoseVector noise = root * white.col(static_cast<Eigen::Index>(m));
    poses_[m] = poses_[m] * motion.delta * Pose::exp(noise);
  }
}

/// As many particles as the places where they are need.
template <class Space>
void ParticleSearch<Space>::resample() {
  constexpr double kCell = 0.2;  // m
  constexpr double kTurnCell = radians(10.0);
  constexpr int kParticlesPerCell = 25;
  std::set<std::array<int, 4>> cells;
  for (std::size_t m = 0; m < poses_.size(); ++m) {
    if (weights_[m] * static_cast<double>(poses_.size()) < 1e-3) continue;
    const Eigen::Isometry3d pose = Space::to_3d(poses_[m]);
    const Eigen::Array3i cell = (pose.translation() / kCell).array().floor().template cast<int>();
    const double yaw = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
    cells.insert({cell.x(), cell.y(), cell.z(), static_cast<int>(std::floor(yaw / kTurnCell))});
  }
  const int wanted = std::clamp(kParticlesPerCell * static_cast<int>(cells.size()), options_.min_particles,
                                options_.max_particles);
  std::vector<Pose> survivors;
  for (const std::size_t m :
       low_variance_resample(weights_, static_cast<std::size_t>(wanted), random_.uniform(0.0, 1.0))) {
    survivors.push_back(poses_[m]);
  }
  poses_ = std::move(survivors);
  weights_.assign(poses_.size(), 1.0 / static_cast<double>(poses_.size()));
}

template <class Space>
std::optional<PoseEstimate<Space>> ParticleSearch<Space>::only_cluster() const {
  if (poses_.empty()) return std::nullopt;
  const auto best = std::max_element(weights_.begin(), weights_.end()) - weights_.begin();
  Pose center = poses_[static_cast<std::size_t>(best)];
  PoseEstimate<Space> estimate;
  for (int round = 0; round < 2; ++round) {
    std::vector<Pose> members;
    std::vector<double> weights;
    double sum = 0.0;
    for (std::size_t m = 0; m < poses_.size(); ++m) {
      if (!is_near<Space>(center, poses_[m], kClusterRadius, kClusterTurn)) continue;
      members.push_back(poses_[m]);
      weights.push_back(weights_[m]);
      sum += weights_[m];
    }
    if (round > 0 && sum < 1.0 - kOtherWeight) return std::nullopt;
    for (double& weight : weights) weight /= sum;
    estimate = mean_of_poses<Space>(members, weights);
    center = estimate.map_from_base;
  }
  const typename Space::PoseVector sigma = estimate.covariance.diagonal().cwiseSqrt();
  const bool is_sharp = (sigma.array() < sigmas<Space>(kLargestSigma, kLargestTurnSigma).array()).all();
  return is_sharp ? std::optional(estimate) : std::nullopt;
}

template <class Space>
ParticleLocalization<Space>::ParticleLocalization(const LocalizationOptions& options, LandmarkMap<Space> map)
    : map_(std::move(map)),
      search_(options),
      random_(static_cast<std::uint64_t>(options.seed), kPictureStream) {}

template <class Space>
void ParticleLocalization<Space>::predict(const MotionStep<Space>& step) {
  motion_ = compound(motion_, step);
}

template <class Space>
std::optional<PoseEstimate<Space>> ParticleLocalization<Space>::observe(const Observations& observations) {
  const bool has_moved = !is_near<Space>(Pose(), motion_.delta, kTravel, kTurn);
  if (observations.empty() || (!picture_.empty() && !has_moved)) return std::nullopt;
  const MotionStep<Space> motion = std::exchange(motion_, {});
  add_to_picture(motion, observations);
  search_.update(map_, motion, observations);
  auto found = search_.only_cluster();
  if (!found || !explains_picture(found->map_from_base)) return std::nullopt;
  if (new_sightings_ < kNewSightings) return std::nullopt;
  new_sightings_ = 0;
  if (!excludes_others(found->map_from_base)) return std::nullopt;
  found->covariance.diagonal() += sigmas<Space>(kRoughening, kTurnRoughening).cwiseAbs2();
  for (const LandmarkEstimate<Space>& landmark :
       map_) {  // the pose comes from the map, whose errors it shares
    found->covariance.template topLeftCorner<Space::kPointDim, Space::kPointDim>() +=
        landmark.covariance / static_cast<double>(map_.size());
  }
  return found;
}

template <class Space>
void ParticleLocalization<Space>::add_to_picture(const MotionStep<Space>& motion,
                                                 const Observations& observations) {
  for (Sighting& sighting : picture_)
    sighting.now_from_then = motion.delta.inverse() * sighting.now_from_then;
  for (Observation<Space> observation : observations) {
    observation.covariance = 2.0 * observation.covariance + kDrift * kDrift * Space::PointMatrix::Identity();
    ++new_sightings_;
    picture_.push_back({Pose(), std::move(observation)});
    if (picture_.size() > kSightings) picture_.pop_front();
  }
}

template <class Space>
bool ParticleLocalization<Space>::explains_picture(const Pose& map_from_base) const {
  if (picture_.size() < kSightings) return false;
  std::size_t explained = 0;
  std::set<int> landmarks;
  for (const Sighting& sighting : picture_) {
    const Match match = best_match<Space>(map_, map_from_base * sighting.now_from_then, sighting.observation);
    if (match.landmark < 0 || match.squared_distance > kExplainedDistance) continue;
    if (resemblance(map_[match.landmark].info, sighting.observation.signature) <= kMisreading) continue;
    ++explained;
    landmarks.insert(match.landmark);
  }
  return static_cast<double>(explained) >= kExplainedShare * static_cast<double>(kSightings) &&
         landmarks.size() >= kLandmarks;
}

template <class Space>
double ParticleLocalization<Space>::log_likelihood(const Pose& map_from_base) const {
  double sum = 0.0;
  for (const Sighting& sighting : picture_) {
    sum +=
        best_match<Space>(map_, map_from_base * sighting.now_from_then, sighting.observation).log_likelihood;
  }
  return sum;
}

/// The pose nearby that explains the picture best: Gauss-Newton, a Kalman filter's correction by all
/// sightings.
template <class Space>
typename Space::Pose ParticleLocalization<Space>::refined(Pose map_from_base) const {
  constexpr int kRounds = 3;
  const typename Space::PoseVector sigma = sigmas<Space>(kClusterRadius, kClusterTurn);
  for (int round = 0; round < kRounds; ++round) {
    Gaussian<Space::kPoseDim> error;
    error.covariance = sigma.cwiseAbs2().asDiagonal();
    for (const Sighting& sighting : picture_) {
      const Pose map_from_then = map_from_base * sighting.now_from_then;
      const Match match = best_match<Space>(map_, map_from_then, sighting.observation);
      if (match.landmark < 0) continue;
      const auto point = predict_point<Space>(map_from_then, map_[match.landmark].position_in_map);
      const Eigen::Matrix<double, Space::kPointDim, Space::kPoseDim> H =
          point.by_pose * sighting.now_from_then.inverse().adjoint();
      const typename Space::Point innovation =
          sighting.observation.position_in_base - point.point_in_base - H * error.mean;
      correct<Space::kPoseDim, Space::kPointDim>(innovation, H, sighting.observation.covariance, &error);
    }
    map_from_base = map_from_base * Pose::exp(error.mean);
  }
  return map_from_base;
}

/// The particles may have lost the truth by chance, so all poses are tried anew, from three of the sightings.
template <class Space>
bool ParticleLocalization<Space>::excludes_others(const Pose& map_from_base) {
  constexpr int kHeadings = 120;
  constexpr std::size_t kMostOthers = 30;
  std::vector<std::pair<double, Pose>> others;
  for (const std::size_t k : {std::size_t{0}, kSightings / 2, kSightings - 1}) {
    const Pose then_from_now = picture_[k].now_from_then.inverse();
    for (const Pose& map_from_then :
         poses_that_see<Space>(map_, picture_[k].observation, kHeadings, &random_)) {
      const Pose pose = map_from_then * then_from_now;
      if (is_near<Space>(map_from_base, pose, kClusterRadius, kClusterTurn)) continue;
      others.emplace_back(log_likelihood(pose), pose);
    }
  }
  const auto better = [](const auto& left, const auto& right) { return left.first > right.first; };
  const std::size_t count = std::min(kMostOthers, others.size());
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count), others.end(),
                    better);
  const double here = log_likelihood(refined(map_from_base));
  return std::none_of(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count),
                      [&](const auto& other) {
                        const Pose pose = refined(other.second);
                        return !is_near<Space>(map_from_base, pose, kClusterRadius, kClusterTurn) &&
                               log_likelihood(pose) > here - kMargin;
                      });
}

template class ParticleSearch<Planar>;
template class ParticleSearch<Spatial>;
template class ParticleLocalization<Planar>;
template class ParticleLocalization<Spatial>;

}  // namespace kinect_ekf_slam
