#pragma once

#include <Eigen/Core>
#include <map>

#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

/// Notices that it is the estimate that is wrong: a source that tells the robot's place, positions or the
/// ranges to one beacon, contradicts it for long and agrees with itself, and no other one supports it.
class PositionWatch {
 public:
  /// `lost_after` in s.
  explicit PositionWatch(double lost_after) : lost_after_(lost_after) {}

  void accepted() {
    streaks_.clear();
    if (is_lost_ && ++accepted_ >= kTrusted) is_lost_ = false;
  }
  /// One outside the gate. `offset` m is how far it is from what the estimate expects, give or take `sigma`
  /// m. Single outliers, and such that differ, are no contradiction. Returns true when it is the estimate
  /// that is wrong, once for each such time.
  bool refused(int source, TimeNs stamp, const Eigen::Vector3d& offset, double sigma) {
    constexpr double kAgreement = 5.0;  // sigmas
    accepted_ = 0;
    Streak& streak = streaks_[source];
    const bool agrees = streak.length > 0 && (offset - streak.last_offset).norm() < kAgreement * sigma;
    if (!agrees) streak = {0, stamp, offset};
    ++streak.length;
    streak.last_offset = offset;
    if (streak.length < kFewest || to_seconds(stamp - streak.since) < lost_after_) return false;
    streaks_.clear();
    is_lost_ = true;
    return true;
  }
  bool is_lost() const { return is_lost_; }
  void reset() { *this = PositionWatch(lost_after_); }

 private:
  static constexpr int kFewest = 5;   ///< that contradict
  static constexpr int kTrusted = 5;  ///< accepted in a row before the robot is no longer lost
  struct Streak {
    int length = 0;  ///< refused in a row that agree
    TimeNs since = 0;
    Eigen::Vector3d last_offset = Eigen::Vector3d::Zero();
  };

  double lost_after_;
  std::map<int, Streak> streaks_;  ///< by source
  int accepted_ = 0;
  bool is_lost_ = false;
};

}  // namespace kinect_ekf_slam
