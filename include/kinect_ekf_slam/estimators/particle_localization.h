#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/estimators/pose_estimate.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"
#include "kinect_ekf_slam/models/measurement.h"
#include "kinect_ekf_slam/models/motion.h"

namespace kinect_ekf_slam {

struct LocalizationOptions {
  int max_particles = 4000;  ///< the search begins with
  int min_particles = 300;   ///< when all are at one place
  int seed = 1;
};

template <class Space>
using LandmarkMap = std::vector<LandmarkEstimate<Space>>;

/// Looks for the robot in a known map, whatever its pose: a particle filter with the map fixed
/// (docs/filters.md).
///
/// The first sighting gives the particles: whichever landmark it is, and however the robot is turned (about
/// the vertical), it stands where that landmark is seen so. Later sightings choose between them. What a
/// landmark looks like (label, radius) speaks for it or against it. Begins again when nothing explains what
/// is seen.
template <class Space>
class ParticleSearch {
 public:
  using Observations = std::vector<Observation<Space>>;

  explicit ParticleSearch(const LocalizationOptions& options);

  /// Moves the particles by `motion`, and weighs them by what is seen there. Does nothing without sightings.
  void update(const LandmarkMap<Space>& map, const MotionStep<Space>& motion,
              const Observations& observations);

  /// The mean over the particles round the best one, when they are close together and hold all but a trace of
  /// the weight. That says nothing about places where no particle is.
  std::optional<PoseEstimate<Space>> only_cluster() const;

  const std::vector<typename Space::Pose>& particles() const { return poses_; }

 private:
  using Pose = typename Space::Pose;

  void seed(const LandmarkMap<Space>& map, const Observations& observations);
  void move(const MotionStep<Space>& motion);
  bool is_hopeless(const std::vector<double>& log_weights, std::size_t sightings);
  void begin_again();
  void resample();

  LocalizationOptions options_;
  RandomStream random_;
  std::vector<Pose> poses_;      ///< map_from_base
  std::vector<double> weights_;  ///< sum one
  std::deque<bool> supported_;   ///< whether any particle explained the last frames
};

/// The kidnapped robot's way home: particles look for the pose, and it is reported when, besides, it explains
/// the last sightings as one rigid picture and no other pose does. Where the map is ambiguous, or another
/// room's, there is no report.
template <class Space>
class ParticleLocalization {
 public:
  using Observations = std::vector<Observation<Space>>;

  ParticleLocalization(const LocalizationOptions& options, LandmarkMap<Space> map);

  void predict(const MotionStep<Space>& step);
  /// The pose of the robot now, once it is certain.
  std::optional<PoseEstimate<Space>> observe(const Observations& observations);

 private:
  using Pose = typename Space::Pose;
  struct Sighting {
    Pose now_from_then;  ///< of the base, by odometry
    Observation<Space> observation;
  };

  void add_to_picture(const MotionStep<Space>& motion, const Observations& observations);
  bool explains_picture(const Pose& map_from_base) const;
  /// No pose but the one given, and those near it, explains the picture.
  bool excludes_others(const Pose& map_from_base);
  double log_likelihood(const Pose& map_from_base) const;  ///< of the picture
  Pose refined(Pose map_from_base) const;

  LandmarkMap<Space> map_;
  ParticleSearch<Space> search_;
  RandomStream random_;
  MotionStep<Space> motion_;  ///< since the sightings that were used last
  std::deque<Sighting> picture_;
  std::size_t new_sightings_ = 0;  ///< since other poses were tried last
};

}  // namespace kinect_ekf_slam
