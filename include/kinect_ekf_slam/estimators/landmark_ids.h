#pragma once

#include <algorithm>
#include <set>

#include "kinect_ekf_slam/core/landmark.h"

namespace kinect_ekf_slam {

/// Gives landmarks their ids: the identity that the detector reads where identities are known, so that people
/// find on the map what stands on the landmark; else, or where that is taken, a number that was never used
/// before.
class LandmarkIds {
 public:
  explicit LandmarkIds(bool by_identity) : by_identity_(by_identity) {}

  int next(const Signature& signature) {
    const bool named = by_identity_ && signature.source_id != kNoId && taken_.count(signature.source_id) == 0;
    while (taken_.count(unused_) > 0) ++unused_;
    const int id = named ? signature.source_id : unused_;
    take(id);
    return id;
  }
  /// An id that is in use: a landmark of a map that was loaded.
  void take(int id) {
    taken_.insert(id);
    constexpr int kHuge = 1000000000;  // an identity beyond it must not use the numbers up
    if (id < kHuge) unused_ = std::max(unused_, id + 1);
  }
  /// The landmark is misplaced and will be placed anew: its identity may name it again.
  void misplaced(const LandmarkInfo& info) {
    if (by_identity_ && info.id == info.source_id) taken_.erase(info.id);
  }
  void clear() {
    taken_.clear();
    unused_ = 0;
  }

 private:
  bool by_identity_;
  int unused_ = 0;
  std::set<int> taken_;
};

}  // namespace kinect_ekf_slam
