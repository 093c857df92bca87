#pragma once

#include <vector>

#include "kinect_ekf_slam/association/gated_pairs.h"
#include "kinect_ekf_slam/association/joint_innovation.h"

namespace kinect_ekf_slam {

/// Joint compatibility branch and bound (Neira and Tardos, IEEE Trans. Robotics and Automation 17(6), 2001).
///
/// Of all ways to pair the sightings of one time with landmarks whose joint innovation, as it grows pair by
/// pair, stays inside the gate, the one with the most pairs, and of these the one nearest. The search tries
/// likely pairs first and stops after `joint_work` pairings: it then has the best that it has seen, at least
/// the greedy one.
template <class Space>
class JointCompatibility : public Associator<Space> {
 public:
  explicit JointCompatibility(const AssociationOptions& options)
      : gates_(options), most_work_(options.joint_work) {}
  std::vector<Assignment> associate(const typename Associator<Space>::Observations& observations,
                                    const PredictedMap<Space>& map) const override;
  AssociationReach reach() const override { return gates_.reach(); }

 private:
  class Search;

  Gates<Space> gates_;
  int most_work_;
};

}  // namespace kinect_ekf_slam
