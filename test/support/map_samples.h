#pragma once

#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/mapping/saved_state.h"

namespace kinect_ekf_slam::testing {

/// A map with numbers that no short decimal can hold, and labels that no careless writer can quote.
template <class Space = Planar>
SavedState sample_map() {
  typename Space::PoseVector twist = Space::PoseVector::Constant(-1e-17);
  twist(0) = 1.0 / 3.0;
  twist(Space::kPoseDim - 1) = 3.0;
  SavedState state;
  state.space = Space::kName;
  state.stamp = 1700000000123456789;
  state.pose = Space::to_vector(Space::retract({}, twist));
  const char* labels[] = {"red",
                          "say \"hi\": {a: [1, 2]} # no comment",
                          "line\nbreak\ttab \\ 'single'",
                          "Säule \xE7\xBA\xA2 \xF0\x9F\x94\xB4",
                          "",
                          "null"};
  for (int i = 0; i < 6; ++i) {
    LandmarkInfo info;
    info.id = 3 * i + 1;
    info.source_id = i == 2 ? kNoId : 40 + i;
    info.radius = 0.05 + 1e-17 * i;
    info.observations = 100U + static_cast<unsigned>(i);
    info.radius_observations = static_cast<unsigned>(i);
    info.label_votes[labels[i]] = 7;
    if (i == 0) info.label_votes["blue"] = 2;
    if (i == 5) info.label_votes.clear();
    state.infos.push_back(info);
  }
  constexpr int kSize = Space::kPoseDim + 6 * Space::kPointDim;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(kSize, kSize);
  state.landmarks_in_map.resize(6, Space::kPointDim);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d point(std::sqrt(2.0 + i), -std::exp(1.0 + i), 1.0 / (3.0 + i));
    state.landmarks_in_map.row(i) = Space::from_3d(point).transpose();
  }
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j <= i; ++j) root(i, j) = 0.1 / (1.0 + i + 2.0 * j) - (i == j ? -0.05 : 0.0);
  }
  const Eigen::MatrixXd square = root * root.transpose();
  state.covariance = square.selfadjointView<Eigen::Lower>();
  return state;
}

/// Equal to the last bit; `last_seen` is of a run and not of a map.
inline ::testing::AssertionResult SameMap(const SavedState& left, const SavedState& right) {
  const auto differ = [](const char* what) { return ::testing::AssertionFailure() << what << " differ"; };
  if (left.space != right.space || left.stamp != right.stamp) return differ("space or stamp");
  if (left.pose != right.pose) return differ("poses");
  if (left.landmarks_in_map.rows() != right.landmarks_in_map.rows() ||
      left.landmarks_in_map != right.landmarks_in_map) {
    return differ("positions");
  }
  if (left.covariance.rows() != right.covariance.rows() || left.covariance != right.covariance) {
    return differ("covariances");
  }
  if (left.infos.size() != right.infos.size()) return differ("sizes");
  for (std::size_t i = 0; i < left.infos.size(); ++i) {
    const LandmarkInfo& a = left.infos[i];
    const LandmarkInfo& b = right.infos[i];
    if (a.id != b.id || a.source_id != b.source_id || a.radius != b.radius ||
        a.observations != b.observations || a.radius_observations != b.radius_observations ||
        a.label_votes != b.label_votes) {
      return differ("landmarks");
    }
  }
  return ::testing::AssertionSuccess();
}

}  // namespace kinect_ekf_slam::testing
