#pragma once

#include <vector>

#include "kinect_ekf_slam/association/associator.h"

namespace kinect_ekf_slam {

/// Squared distance of what is seen besides the place from what is known of the landmark, on the scale of a
/// squared Mahalanobis distance: minus twice the log likelihood, less that of the best fit. Attributes that
/// either side does not know add nothing. Never negative: an attribute may rank or veto, it cannot force a
/// match that the gate forbids.
double attribute_distance(const Signature& seen, const LandmarkInfo& mapped,
                          const AssociationOptions& options);

/// A sighting and a landmark that it may be.
struct GatedPair {
  double squared_distance;  ///< of place and attributes
  std::size_t observation;
  int landmark;
};

/// What association without identities starts from: who may be whom, and what a sighting is if it is nobody.
template <class Space>
struct GatedPairs {
  std::vector<GatedPair> pairs;       ///< inside the gate
  std::vector<Assignment> otherwise;  ///< per observation: created, or the reason why it is not a new one
};

template <class Space>
class Gates {
 public:
  explicit Gates(const AssociationOptions& options);

  /// Inside the gate: a pair. Outside the wider gate of every landmark: new. Between the two: ambiguous.
  GatedPairs<Space> pair(const std::vector<Observation<Space>>& observations,
                         const PredictedMap<Space>& map) const;
  /// A detector that sees two where there is one: of new sightings that may be one object, the nearest
  /// counts.
  void refuse_echoes(const std::vector<Observation<Space>>& observations,
                     std::vector<Assignment>* assignments) const;
  /// The quantile for several sightings together, as many as `count`.
  double joint(int count) const;
  double new_landmark() const { return new_landmark_gate_; }
  AssociationReach reach() const;

 private:
  AssociationOptions options_;
  double gate_;
  double new_landmark_gate_;
  std::vector<double> joint_gates_;  ///< by the number of sightings
};

}  // namespace kinect_ekf_slam
