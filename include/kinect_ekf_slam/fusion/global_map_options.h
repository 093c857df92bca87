#pragma once

#include "kinect_ekf_slam/association/associator.h"

namespace kinect_ekf_slam {

struct AlignmentOptions {
  double gate_probability = 0.999;   ///< of one pair's overlap test
  double max_turn_sigma_deg = 10.0;  ///< deg; a turn less well known, about any axis, is no alignment
};

struct GlobalMapOptions {
  AlignmentOptions alignment;
  AssociationOptions association;     ///< of landmarks between maps; several hypotheses are not kept
  double merge_probability = 0.9999;  ///< of the gate for the difference of two landmarks that are to be one
  int max_places = 600;               ///< of the way; of more, every second, third ... carries the map
  int max_joined_points = 800;  ///< landmarks and path points of local maps that wait to be placed together
};

}  // namespace kinect_ekf_slam
