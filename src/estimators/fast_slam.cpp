#include "kinect_ekf_slam/estimators/fast_slam.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "kinect_ekf_slam/core/chi_square.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kWidestGate = 64.0;  // squared distance; the quantile of 1 - 1e-12 in space is 58

}  // namespace

/// The associator's view of one particle, of the candidates only.
template <class Space>
class FastSlam<Space>::Prediction : public PredictedMap<Space> {
 public:
  Prediction(const FastSlam& slam, const Particle& particle, const std::vector<int>& candidates)
      : slam_(slam), particle_(particle) {
    for (const int track : candidates) {
      if (particle.path.landmark(track) != nullptr) tracks_.push_back(track);
    }
  }
  int size() const override { return static_cast<int>(tracks_.size()); }
  const LandmarkInfo& info(int landmark) const override { return slam_.tracks_[tracks_[landmark]].info; }
  Point point_in_base(int landmark) const override { return particle_.path.expected(tracks_[landmark]).mean; }
  PointMatrix covariance(int landmark) const override {
    return particle_.path.expected(tracks_[landmark]).covariance;
  }
  int track(int landmark) const { return tracks_[landmark]; }

 private:
  const FastSlam& slam_;
  const Particle& particle_;
  std::vector<int> tracks_;
};

template <class Space>
FastSlam<Space>::FastSlam(const EstimatorOptions& options,
                          std::shared_ptr<const Associator<Space>> associator,
                          const PoseEstimate<Space>& initial)
    : options_(options),
      associator_(std::move(associator)),
      random_(static_cast<std::uint64_t>(options.seed), 0),
      particles_(static_cast<std::size_t>(options.particles)),
      weights_(particles_.size(), 1.0 / options.particles),
      contradictions_(options),
      ids_(associator_->knows_identities()) {
  set_pose(initial);
}

template <class Space>
void FastSlam<Space>::predict(const MotionStep<Space>& step) {
  motion_ = compound(motion_, step);
}

template <class Space>
UpdateReport FastSlam<Space>::observe(TimeNs stamp, const Observations& observations) {
  if (observations.empty()) return {};
  move_particles();
  const bool draws_before_it_looks = options_.type == EstimatorOptions::Type::kFastSlam1;
  const auto draw_after = static_cast<std::size_t>(options_.draw_after);
  if (draws_before_it_looks) draw_poses(draw_after);
  const std::vector<int> near = candidates(observations);
  std::vector<double> log_weights(particles_.size());
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    log_weights[m] = std::log(weights_[m]) + correct(stamp, observations, near, &particles_[m]);
  }
  weights_ = normalized_weights(log_weights);
  add_landmarks(stamp, observations);

  std::set<int> touched;
  for (const Particle& particle : particles_) {
    touched.insert(particle.path.window().begin(), particle.path.window().end());
  }
  if (!draws_before_it_looks) draw_poses(draw_after);
  UpdateReport report = vote(observations.size());
  note(stamp, observations, &report);
  for (const int track : touched) bound(track);
  const double enough = options_.resample_below * static_cast<double>(particles_.size());
  if (effective_sample_size(weights_) < enough) resample();
  return report;
}

template <class Space>
void FastSlam<Space>::move_particles() {
  constexpr double kLongestTail = 100.0;
  for (Particle& particle : particles_) {
    double tail = 1.0;  // a Gaussian over the root of an independent chi-square with one dof is a Cauchy
    if (options_.motion_tail == EstimatorOptions::MotionTail::kCauchy) {
      tail = std::min(1.0 / std::abs(random_.normal()), kLongestTail);
    }
    particle.path.move({motion_.delta, tail * tail * motion_.covariance});
  }
  motion_ = {};
}

template <class Space>
void FastSlam<Space>::draw_poses(std::size_t landmarks) {
  const Eigen::MatrixXd white = standardized_draws(kPoseDim, options_.particles, &random_);
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    if (particles_[m].path.window().size() < landmarks) continue;
    particles_[m].path.draw(white.col(static_cast<Eigen::Index>(m)));
  }
}

template <class Space>
double FastSlam<Space>::squared_reach(const Observation<Space>& observation) const {
  double variance = 0.0;
  for (const Particle& particle : particles_) {
    const PoseEstimate<Space> pose = particle.path.pose();
    const typename Space::PointByPose by_pose =
        Space::point_by_pose(observation.position_in_base) * local_from_error<Space>(pose.map_from_base);
    variance = std::max(variance, (by_pose * pose.covariance * by_pose.transpose()).trace());
  }
  return kWidestGate * (variance + observation.covariance.trace());
}

template <class Space>
std::vector<int> FastSlam<Space>::candidates(const Observations& observations) const {
  const bool by_identity = associator_->knows_identities();
  std::vector<Box> seen(by_identity ? 0 : observations.size());
  std::vector<double> reach(seen.size());
  for (std::size_t k = 0; k < seen.size(); ++k) {
    for (const Particle& particle : particles_) {
      seen[k].extend(Point(particle.path.pose().map_from_base * observations[k].position_in_base));
    }
    reach[k] = squared_reach(observations[k]);
  }
  const auto matters = [&](const Track& track, std::size_t k) {
    if (by_identity) return track.info.source_id == observations[k].signature.source_id;
    const double distance = std::sqrt(seen[k].squaredExteriorDistance(track.box));
    return distance <=
           std::max(std::sqrt(reach[k] + kWidestGate * track.variance), associator_->reach().distance);
  };
  std::vector<int> tracks;
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    if (tracks_[track].holders == 0) continue;
    for (std::size_t k = 0; k < observations.size(); ++k) {
      if (!matters(tracks_[track], k)) continue;
      tracks.push_back(static_cast<int>(track));
      break;
    }
  }
  return tracks;
}

/// The weight is the likelihood of the sightings, given the particle's path and what is not drawn of it.
template <class Space>
double FastSlam<Space>::correct(TimeNs stamp, const Observations& observations,
                                const std::vector<int>& candidates, Particle* particle) const {
  const Prediction prediction(*this, *particle, candidates);
  particle->assignments = associator_->associate(observations, prediction);
  std::vector<typename PathParticle<Space>::Sighting> sightings;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    Assignment& assignment = particle->assignments[k];
    if (assignment.landmark >= 0) assignment.landmark = prediction.track(assignment.landmark);
    if (assignment.verdict != Verdict::kMatched) continue;
    sightings.push_back({assignment.landmark, observations[k].position_in_base,
                         measurement_noise(stamp, observations[k], assignment)});
  }
  const std::vector<std::optional<Fit>> fits = particle->path.correct(sightings);
  auto next_fit = fits.begin();
  particle->nis = 0.0;
  particle->dof = 0;
  double log_weight = 0.0;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    Assignment& assignment = particle->assignments[k];
    std::optional<Fit> fit;
    if (assignment.verdict == Verdict::kMatched) fit = *next_fit++;
    if (assignment.verdict == Verdict::kMatched && !fit) assignment.verdict = Verdict::kSingular;
    log_weight += fit ? fit->log_likelihood : log_unexplained(observations[k]);
    if (fit) particle->nis += fit->squared_distance;
    if (fit) particle->dof += kPointDim;
  }
  return log_weight;
}

/// R of a match, larger where the sighting is unlikely or says again what the last one said.
template <class Space>
typename Space::PointMatrix FastSlam<Space>::measurement_noise(TimeNs stamp,
                                                               const Observation<Space>& observation,
                                                               const Assignment& assignment) const {
  return matched_noise<Space>(observation, tracks_[assignment.landmark].info, stamp,
                              assignment.squared_distance, options_.robust_threshold);
}

/// That of a match that is all but impossible, so that no particle gains by refusing.
template <class Space>
double FastSlam<Space>::log_unexplained(const Observation<Space>& observation) const {
  constexpr double kProbability = 0.9999;
  static const double distance = chi_square_quantile(kProbability, kPointDim);
  const double doubt =
      options_.robust_threshold > 0.0 ? std::max(1.0, distance / options_.robust_threshold) : 1.0;
  const PointMatrix noise = doubt * observation.covariance;
  const auto fit = fit_of<kPointDim>(Point::Zero(), noise);
  return (fit ? fit->log_likelihood : 0.0) - 0.5 * distance / doubt;
}

template <class Space>
void FastSlam<Space>::add_landmarks(TimeNs stamp, const Observations& observations) {
  const auto used =
      std::count_if(tracks_.begin(), tracks_.end(), [](const Track& track) { return track.holders > 0; });
  int free = options_.max_landmarks - static_cast<int>(used);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    int track = -1;
    for (Particle& particle : particles_) {
      Assignment& assignment = particle.assignments[k];
      if (assignment.verdict != Verdict::kCreated) continue;
      if (fixed_map_) {
        assignment.verdict = Verdict::kNotInMap;
      } else if (track < 0 && free == 0) {
        assignment.verdict = Verdict::kMapFull;
      } else {
        if (track < 0) {
          track = new_track(stamp, observations[k].signature);
          --free;
        }
        particle.path.place(track, observations[k]);
        assignment.landmark = track;
      }
    }
  }
}

template <class Space>
int FastSlam<Space>::new_track(TimeNs stamp, const Signature& signature) {
  auto track =
      std::find_if(tracks_.begin(), tracks_.end(), [](const Track& old) { return old.holders == 0; });
  if (track == tracks_.end()) track = tracks_.emplace(track);
  *track = {};
  contradictions_.forget(static_cast<int>(track - tracks_.begin()));
  track->holders = 1;  // at least: the one that asked
  track->info.id = ids_.next(signature);
  track->info.add(stamp, signature);
  return static_cast<int>(track - tracks_.begin());
}

template <class Space>
UpdateReport FastSlam<Space>::vote(std::size_t observations) const {
  UpdateReport report;
  for (std::size_t k = 0; k < observations; ++k) {
    struct Votes {
      double weight = 0.0;
      double squared_distance = 0.0;
    };
    std::map<std::pair<Verdict, int>, Votes> choices;
    for (std::size_t m = 0; m < particles_.size(); ++m) {
      const Assignment& assignment = particles_[m].assignments[k];
      Votes& votes = choices[{assignment.verdict, assignment.landmark}];
      votes.weight += weights_[m];
      votes.squared_distance += weights_[m] * assignment.squared_distance;
    }
    const auto& [choice, votes] = *std::max_element(
        choices.begin(), choices.end(),
        [](const auto& left, const auto& right) { return left.second.weight < right.second.weight; });
    report.assignments.push_back({choice.first, choice.second, votes.squared_distance / votes.weight});
    if (choice.first == Verdict::kMatched) report.dof += kPointDim;
  }
  if (report.dof == 0) return report;
  double weight = 0.0;
  double nis = 0.0;
  for (std::size_t m = 0; m < particles_.size(); ++m) {
    if (particles_[m].dof != report.dof) continue;
    weight += weights_[m];
    nis += weights_[m] * particles_[m].nis;
  }
  report.nis = nis / weight;
  return report;
}

/// Keeps what all particles have in common up to date, and turns the report's tracks into ids.
template <class Space>
void FastSlam<Space>::note(TimeNs stamp, const Observations& observations, UpdateReport* report) {
  for (std::size_t k = 0; k < observations.size(); ++k) {
    const Assignment& assignment = report->assignments[k];
    if (assignment.verdict != Verdict::kMatched) continue;
    LandmarkInfo& info = tracks_[assignment.landmark].info;
    if (fixed_map_) {
      info.last_seen = stamp;  // the next one may be an echo
    } else {
      info.add(stamp, observations[k].signature);
    }
  }
  if (!fixed_map_) {
    const auto observations_of = [this](int track) {
      return static_cast<int>(tracks_[track].info.observations);
    };
    for (const std::size_t k : contradictions_.misplaced(report->assignments, observations_of)) {
      replace(report->assignments[k].landmark, stamp, observations[k]);
      report->assignments[k].verdict = Verdict::kCreated;
    }
  }
  for (Assignment& assignment : report->assignments) {
    if (assignment.landmark >= 0) assignment.landmark = tracks_[assignment.landmark].info.id;
  }
}

/// The landmark is elsewhere: every particle places it anew.
template <class Space>
void FastSlam<Space>::replace(int track, TimeNs stamp, const Observation<Space>& observation) {
  ids_.misplaced(tracks_[track].info);
  tracks_[track].info = {};
  tracks_[track].info.id = ids_.next(observation.signature);
  tracks_[track].info.add(stamp, observation.signature);
  for (Particle& particle : particles_) particle.path.place(track, observation);
  bound(track);
}

/// Finds out again which particles have a landmark, and where.
template <class Space>
void FastSlam<Space>::bound(int index) {
  Track& track = tracks_[index];
  track.holders = 0;
  track.box.setEmpty();
  track.variance = 0.0;
  for (const Particle& particle : particles_) {
    const Landmark* landmark = particle.path.landmark(index);
    if (landmark == nullptr) continue;
    ++track.holders;
    track.box.extend(landmark->mean);
    track.variance = std::max(track.variance, landmark->covariance.trace());
  }
  if (track.holders == 0) ids_.misplaced(track.info);
}

template <class Space>
void FastSlam<Space>::resample() {
  const std::vector<std::size_t> chosen =
      low_variance_resample(weights_, particles_.size(), random_.uniform(0.0, 1.0));
  std::vector<Particle> survivors;
  survivors.reserve(chosen.size());
  for (const std::size_t m : chosen) survivors.push_back(particles_[m]);
  particles_ = std::move(survivors);
  std::fill(weights_.begin(), weights_.end(), 1.0 / static_cast<double>(weights_.size()));
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    const int holders = tracks_[track].holders;
    if (holders > 0 && holders < options_.particles) bound(static_cast<int>(track));
  }
}

template class FastSlam<Planar>;
template class FastSlam<Spatial>;

}  // namespace kinect_ekf_slam
