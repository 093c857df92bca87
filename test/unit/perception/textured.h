#pragma once

#include <cstdint>

#include "test/unit/perception/rendered.h"

namespace kinect_ekf_slam::testing {

/// A wall 3 m ahead of camera_at() with a pattern and nothing else.
inline Scene textured_wall(std::uint64_t pattern = 1) {
  Scene scene;
  scene.panels.push_back({{3.0, 4.0, 4.0}, {0.0, -8.0, 0.0}, {0.0, 0.0, -6.0}, blotches(800, 600, pattern)});
  return scene;
}

/// That wall, a floor, a wall on the left and a panel in the room.
inline Scene textured_room() {
  Scene scene = textured_wall();
  scene.panels.push_back({{-4.0, 4.0, 0.0}, {8.0, 0.0, 0.0}, {0.0, -8.0, 0.0}, blotches(800, 800, 2)});
  scene.panels.push_back({{-4.0, 1.5, 4.0}, {8.0, 0.0, 0.0}, {0.0, 0.0, -4.0}, blotches(800, 400, 3)});
  scene.panels.push_back(upright_panel({1.8, -0.4, 1.0}, 3.0, 0.6, blotches(60, 60, 4)));
  return scene;
}

}  // namespace kinect_ekf_slam::testing
