#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "kinect_ekf_slam/estimators/pose_parts.h"
#include "kinect_ekf_slam/mapping/local_map.h"
#include "kinect_ekf_slam/mapping/local_map_options.h"
#include "kinect_ekf_slam/mapping/managed_map.h"

namespace kinect_ekf_slam {

/// SLAM in one local map after the other (docs/theory.md, section 13; lines 4 to 14 of the source's algorithm
/// 3).
///
/// Where a look matches too few landmarks for a while, or the pose has become too uncertain, the map is
/// closed and the next one starts in a frame of its own. The pose that is told leads through all of them, as
/// if they were a chain: right from map to map, uncertain as dead reckoning over many. The landmarks are
/// those of the present map.
template <class Space>
class LocalMaps : public SlamEstimator<Space> {
 public:
  using Observations = std::vector<Observation<Space>>;

  /// `make_map` makes the empty map that each local map starts with, the robot at the given pose.
  using MakeMap = std::function<std::unique_ptr<ManagedMap<Space>>(const PoseEstimate<Space>&)>;
  LocalMaps(const LocalMapOptions& options, MakeMap make_map,
            std::shared_ptr<const Associator<Space>> associator, const PoseEstimate<Space>& initial);
  LocalMaps(const LocalMaps& other);

  void predict(const MotionStep<Space>& step) override { map_->predict(step); }
  UpdateReport observe(TimeNs stamp, const Observations& observations) override;
  /// Nobody looked, and the path goes on.
  void go_on(TimeNs stamp);

  PoseEstimate<Space> pose() const override { return product<Space>(map_from_local_, map_->pose()); }
  std::vector<LandmarkEstimate<Space>> landmarks() const override;
  /// Of the present local map, seen from the start of the run.
  SlamState<Space> snapshot() const override;
  /// Starts a new chain with this map; the ones before are kept, and do not lead to it.
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override;
  void set_map_fixed(bool fixed) override { map_->set_map_fixed(fixed); }
  std::unique_ptr<SlamEstimator<Space>> clone() const override { return std::make_unique<LocalMaps>(*this); }

  /// All so far; the last one is the present one, as if it were closed now.
  std::vector<LocalMap<Space>> maps() const;

 private:
  void start_map();
  void start_time(TimeNs stamp);
  /// The pose is where the path has come to at `stamp`.
  void keep_pose(TimeNs stamp);
  void close_map();
  LocalMap<Space> closed() const;
  bool is_over(TimeNs stamp) const;
  bool is_too_uncertain() const;
  void keep_place(TimeNs stamp);

  LocalMapOptions options_;
  MakeMap make_map_;
  std::shared_ptr<const Associator<Space>> associator_;
  std::vector<LocalMap<Space>> closed_;
  PoseEstimate<Space> map_from_local_;
  std::unique_ptr<ManagedMap<Space>> map_;
  LocalMap<Space> present_;  ///< its times and poses; the state is in `map_`
  bool started_ = false;     ///< its time is known
  bool held_ = false;        ///< a look has matched enough landmarks
  TimeNs last_held_ = 0;
};

}  // namespace kinect_ekf_slam
