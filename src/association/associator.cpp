#include "kinect_ekf_slam/association/associator.h"

#include <stdexcept>

#include "kinect_ekf_slam/association/joint_compatibility.h"
#include "kinect_ekf_slam/association/known_identity.h"
#include "kinect_ekf_slam/association/nearest_neighbor.h"

namespace kinect_ekf_slam {

template <class Space>
std::unique_ptr<Associator<Space>> make_associator(const AssociationOptions& options) {
  switch (options.type) {
    case AssociationOptions::Type::kKnown:
      return std::make_unique<KnownIdentity<Space>>(options);
    case AssociationOptions::Type::kNearestNeighbor:
    case AssociationOptions::Type::kMultiHypothesis:  // decides by itself; what it must be shown is the same
      return std::make_unique<NearestNeighbor<Space>>(options);
    case AssociationOptions::Type::kJointCompatibility:
      return std::make_unique<JointCompatibility<Space>>(options);
  }
  throw std::invalid_argument("make_associator: unknown association type");
}

template std::unique_ptr<Associator<Planar>> make_associator<Planar>(const AssociationOptions&);
template std::unique_ptr<Associator<Spatial>> make_associator<Spatial>(const AssociationOptions&);

}  // namespace kinect_ekf_slam
