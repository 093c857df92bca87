#pragma once

#include <gtest/gtest.h>

#include <string>

#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam::testing {

/// For typed tests over all spaces: TYPED_TEST_SUITE(Suite, testing::Spaces, testing::SpaceNames).
using Spaces = ::testing::Types<Planar, Spatial>;

struct SpaceNames {
  template <class Space>
  static std::string GetName(int /*index*/) {
    return Space::kName;
  }
};

}  // namespace kinect_ekf_slam::testing
