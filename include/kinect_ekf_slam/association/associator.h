#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

#include "kinect_ekf_slam/core/landmark.h"
#include "kinect_ekf_slam/models/measurement.h"

namespace kinect_ekf_slam {

struct AssociationOptions {
  enum class Type { kKnown, kNearestNeighbor, kJointCompatibility, kMultiHypothesis };
  Type type = Type::kNearestNeighbor;
  /// A detection may be a landmark when its squared Mahalanobis distance is below the chi-square quantile of
  /// this probability: 0.975 gives the report's alpha, 7.378 in the plane and 9.348 in space.
  double gate_probability = 0.975;
  /// Without identities: a detection is a new landmark when it lies outside the quantile of this probability
  /// for every landmark of the map; between the two gates it is nothing.
  double new_landmark_probability = 0.99999;
  /// Without identities: m; a detection nearer than this to a mapped landmark is never a new one.
  double new_landmark_distance = 0.0;
  int joint_work = 2000;  ///< joint compatibility: pairings that one message may try

  // Multiple hypotheses: how the sightings that are no landmark of the map are spread, and how much is kept.
  double clutter_density = 1e-3;       ///< sightings of nothing, per m^2 (m^3 in space) and look
  double new_landmark_density = 1e-2;  ///< sightings of unmapped landmarks, likewise
  int max_hypotheses = 30;
  double decide_after = 60.0;  ///< s; what the best hypothesis held so long ago is final
  double prune_width = 14.0;   ///< hypotheses so much less likely than the best, as log ratio, are dropped
  double branch_width = 10.0;  ///< likewise, ways to explain the sightings of one time
  double clutter_width = 5.0;  ///< likewise, taking a sighting for clutter

  // Attributes, where identities are not known. What they say is added to the squared distance.
  double label_error = 0.05;      ///< share of the labels that are misread
  double radius_sigma = 0.0;      ///< m, of one sighting's radius; 0: radii are not compared
  double descriptor_sigma = 0.0;  ///< length of the difference of two descriptors; 0: they are not compared
};

/// What the map lets a sensor expect: the associator's view of an estimator.
template <class Space>
class PredictedMap {
 public:
  virtual ~PredictedMap() = default;
  virtual int size() const = 0;
  virtual const LandmarkInfo& info(int landmark) const = 0;
  /// h(x), m, in the base frame.
  virtual typename Space::Point point_in_base(int landmark) const = 0;
  /// H P H^T, m^2: the innovation's covariance without the measurement noise.
  virtual typename Space::PointMatrix covariance(int landmark) const = 0;
  /// H_a P H_b^T, m^2, of two different landmarks. Zero where the pose is given, as to a particle.
  virtual typename Space::PointMatrix cross_covariance(int /*a*/, int /*b*/) const {
    return Space::PointMatrix::Zero();
  }
};

/// What one observation is taken for.
struct Assignment {
  Verdict verdict =
      Verdict::kOutsideGate;  ///< kMatched, kCreated (a new landmark), or the reason for neither
  /// Index in the map when matched, or of the one that refused it; when created the id to give, -1: any.
  int landmark = -1;
  double squared_distance = std::numeric_limits<double>::quiet_NaN();  ///< Mahalanobis, to that landmark
};

/// A landmark farther from an observation than this, by both measures, has no part in what becomes of it.
struct AssociationReach {
  double squared_mahalanobis = std::numeric_limits<double>::infinity();
  double distance = std::numeric_limits<double>::infinity();  ///< m
};

/// Decides which landmark each observation of one time is. Stateless: the same view gives the same answer.
template <class Space>
class Associator {
 public:
  using Observations = std::vector<Observation<Space>>;
  virtual ~Associator() = default;
  /// One assignment an observation, in their order; no landmark is matched twice.
  virtual std::vector<Assignment> associate(const Observations& observations,
                                            const PredictedMap<Space>& map) const = 0;
  /// True when landmarks are told apart by the identity that the detector reads.
  virtual bool knows_identities() const { return false; }
  /// What an associator that does not know identities must be shown of the map; it may always see more.
  virtual AssociationReach reach() const { return {}; }
};

template <class Space>
std::unique_ptr<Associator<Space>> make_associator(const AssociationOptions& options);

}  // namespace kinect_ekf_slam
