#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/estimators/contradictions.h"
#include "kinect_ekf_slam/estimators/gaussian.h"
#include "kinect_ekf_slam/estimators/landmark_ids.h"
#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/estimators/particles.h"
#include "kinect_ekf_slam/estimators/path_particle.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

/// FastSLAM 1.0 and 2.0 (docs/filters.md): given the robot's path the landmarks are independent, so each
/// particle is a path with one small Kalman filter a landmark. (Montemerlo, Thrun, Koller, Wegbreit,
/// AAAI 2002 and IJCAI 2003.)
///
/// 1.0 draws the pose from the motion, and then looks; 2.0 looks first. Here both wait with the draw until
/// some landmarks were seen (`draw_after`), until when each particle is a Kalman filter of the pose and
/// those; with `draw_after` 1 they are the authors'. The motion since the last look is one Gaussian that all
/// particles share, so a prediction costs the same however many there are. A resampled particle shares its
/// parent's map until it changes it: with M particles and n landmarks a sighting costs O(M log n).
///
/// Particles decide by themselves which landmark a sighting is. What one particle takes for new is a landmark
/// of the estimate when particles of more than half of the weight have it.
template <class Space>
class FastSlam : public SlamEstimator<Space> {
 public:
  FastSlam(const EstimatorOptions& options, std::shared_ptr<const Associator<Space>> associator,
           const PoseEstimate<Space>& initial);

  void predict(const MotionStep<Space>& step) override;
  UpdateReport observe(TimeNs stamp, const std::vector<Observation<Space>>& observations) override;
  PoseEstimate<Space> pose() const override;
  std::vector<LandmarkEstimate<Space>> landmarks() const override;
  SlamState<Space> snapshot() const override;
  /// Draws the poses from the state, and gives each particle the landmarks as they are, given its pose. What
  /// the landmarks' errors have in common beyond that is lost: it would take particles as many as it has
  /// dimensions.
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override;
  /// The particles go on learning what they need to tell how uncertain the pose is; the map that is shown is
  /// the fixed one, and comes back when it may change again.
  void set_map_fixed(bool fixed) override;
  std::unique_ptr<SlamEstimator<Space>> clone() const override { return std::make_unique<FastSlam>(*this); }

 private:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseVector = typename Space::PoseVector;
  using Observations = std::vector<Observation<Space>>;
  using Landmark = typename PathParticle<Space>::Landmark;
  using Box = Eigen::AlignedBox<double, kPointDim>;

  struct Particle {
    PathParticle<Space> path;
    std::vector<Assignment> assignments;  ///< of the last observations; `landmark` is the index in `tracks_`
    double nis = 0.0;                     ///< of the last update
    int dof = 0;
  };
  /// What the particles have in common of a landmark.
  struct Track {
    LandmarkInfo info;
    int holders = 0;        ///< particles that have it; none: the track is free
    Box box;                ///< m, in the map; holds the landmark's mean of every particle
    double variance = 0.0;  ///< m^2, the largest trace of its covariance
  };
  class Prediction;

  /// Brings all particles to the present.
  void move_particles();
  /// The particle where it is now.
  PathParticle<Space> present(const Particle& particle) const;
  /// Draws the poses of the particles that have seen at least so many landmarks since they were drawn.
  void draw_poses(std::size_t landmarks);
  /// Tracks that can matter to the observations, whatever the particle.
  std::vector<int> candidates(const Observations& observations) const;
  /// How far from an observation that a particle puts there a landmark's mean can be and still matter, m^2.
  double squared_reach(const Observation<Space>& observation) const;
  /// Associates, and corrects the particle by what is matched; returns the logarithm of the weight that it
  /// earns.
  double correct(TimeNs stamp, const Observations& observations, const std::vector<int>& candidates,
                 Particle* particle) const;
  PointMatrix measurement_noise(TimeNs stamp, const Observation<Space>& observation,
                                const Assignment& assignment) const;
  /// Log-likelihood of an observation that is no landmark of the particle's map.
  double log_unexplained(const Observation<Space>& observation) const;
  void add_landmarks(TimeNs stamp, const Observations& observations);
  int new_track(TimeNs stamp, const Signature& signature);
  /// What most of the weight takes the observations for; `landmark` is the track.
  UpdateReport vote(std::size_t observations) const;
  void note(TimeNs stamp, const Observations& observations, UpdateReport* report);
  void replace(int track, TimeNs stamp, const Observation<Space>& observation);
  void bound(int track);
  void resample();
  void fix_map(const SlamState<Space>& state);
  static void add_window(const PathParticle<Space>& path, double weight, const std::vector<int>& tracks,
                         Eigen::MatrixXd* covariance);

  /// The landmark's distribution over the particles that have it; nothing when those weigh half or less.
  std::optional<Landmark> landmark(int track) const;
  /// Tracks of the landmarks that the estimate consists of.
  std::vector<int> established() const;

  EstimatorOptions options_;
  std::shared_ptr<const Associator<Space>> associator_;
  RandomStream random_;
  std::vector<Particle> particles_;
  std::vector<double> weights_;  ///< sum one
  std::vector<Track> tracks_;
  MotionStep<Space> motion_;       ///< since the particles' poses
  Contradictions contradictions_;  ///< by track
  LandmarkIds ids_;
  std::optional<SlamState<Space>> fixed_map_;  ///< the landmarks of this state; its pose is none
};

}  // namespace kinect_ekf_slam
