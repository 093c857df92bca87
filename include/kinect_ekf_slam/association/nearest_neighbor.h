#pragma once

#include <vector>

#include "kinect_ekf_slam/association/associator.h"

namespace kinect_ekf_slam {

/// Pairs observations with the landmarks nearest by Mahalanobis distance, best pair first, one to one.
///
/// Inside the gate: matched. Beyond the wider gate of every landmark: new. Between the two: ambiguous, and
/// left alone.
template <class Space>
class NearestNeighbor : public Associator<Space> {
 public:
  explicit NearestNeighbor(const AssociationOptions& options);
  std::vector<Assignment> associate(const typename Associator<Space>::Observations& observations,
                                    const PredictedMap<Space>& map) const override;
  AssociationReach reach() const override;

 private:
  void refuse_echoes(const typename Associator<Space>::Observations& observations,
                     std::vector<Assignment>* assignments) const;

  double gate_;
  double new_landmark_gate_;
  double new_landmark_distance_;
};

}  // namespace kinect_ekf_slam
