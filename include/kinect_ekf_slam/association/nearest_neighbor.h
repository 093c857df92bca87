#pragma once

#include <vector>

#include "kinect_ekf_slam/association/gated_pairs.h"

namespace kinect_ekf_slam {

/// Pairs observations with the landmarks nearest by Mahalanobis distance, best pair first, one to one.
///
/// Inside the gate: matched. Beyond the wider gate of every landmark: new. Between the two: ambiguous, and
/// left alone.
template <class Space>
class NearestNeighbor : public Associator<Space> {
 public:
  explicit NearestNeighbor(const AssociationOptions& options) : gates_(options) {}
  std::vector<Assignment> associate(const typename Associator<Space>::Observations& observations,
                                    const PredictedMap<Space>& map) const override;
  AssociationReach reach() const override { return gates_.reach(); }

 private:
  Gates<Space> gates_;
};

}  // namespace kinect_ekf_slam
