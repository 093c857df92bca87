#pragma once

#include <vector>

#include "kinect_ekf_slam/association/associator.h"

namespace kinect_ekf_slam {

/// Takes the detector's word for who a landmark is, and the gate's for whether it can be there.
///
/// Of several observations with one identity only the one that fits best is kept: a detector that sees two
/// where there is one must not count twice.
template <class Space>
class KnownIdentity : public Associator<Space> {
 public:
  explicit KnownIdentity(const AssociationOptions& options);
  std::vector<Assignment> associate(const typename Associator<Space>::Observations& observations,
                                    const PredictedMap<Space>& map) const override;
  bool knows_identities() const override { return true; }

 private:
  double gate_;
};

}  // namespace kinect_ekf_slam
