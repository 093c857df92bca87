#include "kinect_ekf_slam/pipeline/global_mapper.h"

#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "kinect_ekf_slam/fusion/beacon_localization.h"
#include "kinect_ekf_slam/fusion/global_map.h"
#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "kinect_ekf_slam/models/measurement.h"
#include "kinect_ekf_slam/pipeline/motion_track.h"
#include "kinect_ekf_slam/pipeline/sightings.h"
#include "kinect_ekf_slam/pipeline/usable_position.h"

namespace kinect_ekf_slam {
namespace {

/// Several hypotheses are one map each, and a local map is one.
AssociationOptions single_hypothesis(AssociationOptions options) {
  if (options.type == AssociationOptions::Type::kMultiHypothesis) {
    options.type = AssociationOptions::Type::kJointCompatibility;
  }
  return options;
}

/// The attitude's error stands in the map's axes.
template <class Space>
HeadingPrior<Space> attitude_of(const GlobalPosition& position) {
  HeadingPrior<Space> attitude;
  Eigen::Isometry3d global_from_base = Eigen::Isometry3d::Identity();
  global_from_base.linear() = position.map_from_base->toRotationMatrix();
  attitude.global_from_local = Space::pose_from_3d(global_from_base);
  for (int i = 0; i < Space::kTurnDim; ++i) {
    for (int j = 0; j < Space::kTurnDim; ++j) {
      attitude.covariance(i, j) =
          position.covariance(Space::kPoseAxes[Space::kPointDim + i], Space::kPoseAxes[Space::kPointDim + j]);
    }
  }
  return attitude;
}

template <class Space>
GlobalMap3d::Segment to_3d(const GlobalSegment<Space>& segment) {
  GlobalMap3d::Segment result;
  result.first_map = segment.first_map;
  result.last_map = segment.last_map;
  result.start = segment.start;
  result.end = segment.end;
  result.refusal = segment.refusal;
  result.positions = segment.positions;
  if (!segment.refusal.empty()) return result;
  result.global_from_local = to_3d<Space>(segment.start, segment.global_from_local);
  for (const auto& disagreement : segment.disagreements) {
    result.left_out.push_back({disagreement.stamp, Space::to_3d(disagreement.value.by_path.mean),
                               Space::to_3d(disagreement.value.by_global_position.mean),
                               disagreement.value.squared_distance});
  }
  for (const auto& pose : segment.path) result.path.push_back(to_3d<Space>(pose.stamp, pose.value));
  return result;
}

template <class Space>
class SpaceMapper : public GlobalMapper {
 public:
  explicit SpaceMapper(const PipelineOptions& options)
      : options_(options),
        motion_(options.input, options.motion),
        local_maps_(make_local_maps<Space>(options.estimator, single_hypothesis(options.association),
                                           options.life_cycle, options.global_mapping.local_maps,
                                           PoseEstimate<Space>())) {
    options_.global_mapping.integration.association = single_hypothesis(options.association);
  }

  void add(const SensorFrame& frame) override {
    if (motion_.is_past(frame.stamp)) return;
    if (!first_) first_ = frame.stamp;
    if (const auto step = motion_.advance(frame)) local_maps_->predict(*step);
    if (frame.global_position) take(*frame.global_position, frame.stamp, false);
    if (frame.position) take(*frame.position, frame.stamp, true);
    if (!frame.ranges.empty()) take(frame.ranges, frame.stamp);
    if (frame.detections) {
      local_maps_->observe(frame.stamp, Sightings<Space>(*frame.detections, options_.sensor).observations);
      last_pose_ = frame.stamp;
    } else if (!last_pose_ || to_seconds(frame.stamp - *last_pose_) >= kPosePeriod) {
      local_maps_->go_on(frame.stamp);
      last_pose_ = frame.stamp;
    }
  }

  void break_path() override { local_maps_->set_pose(local_maps_->pose()); }

  std::function<GlobalMap3d()> integration() const override {
    return [maps = local_maps_->maps(), places = places_, ignored = ignored_,
            in_map = in_map_.value_or(false), options = options_.global_mapping.integration] {
      const GlobalMap<Space> global = integrate_maps<Space>(maps, places, options);
      GlobalMap3d result;
      result.positions_in_map = in_map;
      result.ignored = ignored;
      result.merged_landmarks = global.merged_landmarks;
      for (const auto& landmark : global.landmarks) {
        if (landmark.info.confirmed) result.landmarks.push_back(to_3d<Space>(landmark));
      }
      for (const auto& segment : global.segments) result.segments.push_back(to_3d<Space>(segment));
      for (const auto& place : places) {
        result.positions.push_back({place.stamp, Space::to_3d(place.value.antenna.mean)});
      }
      return result;
    };
  }

 private:
  static constexpr double kPosePeriod = 0.05;  // s between poses of the path where nobody looks

  void take(const GlobalPosition& position, TimeNs stamp, bool in_map) {
    if (!is_usable(position) || options_.positions.is_withheld(to_seconds(stamp - *first_))) return;
    GlobalPlace<Space> place;
    place.antenna.mean = Space::from_3d(position.position_in_map);
    place.antenna.covariance =
        Space::from_3d(Eigen::Matrix3d(position.covariance.template topLeftCorner<3, 3>()));
    place.antenna_in_base = Space::from_3d(position.antenna_in_base);
    if (position.map_from_base) place.attitude = attitude_of<Space>(position);
    keep(place, stamp, in_map);
  }

  /// Line 15: ranges tell the place by themselves. The beacons are in the map's frame.
  void take(const std::vector<BeaconRange>& ranges, TimeNs stamp) {
    if (!buoys_) start_buoys(stamp);
    std::vector<BeaconRange> level_ranges;
    for (const BeaconRange& range : ranges) {
      if (const auto level = on_a_level(range)) level_ranges.push_back(*level);
    }
    const auto report = buoys_->update(stamp, level_ranges);
    if (!report.fix) return;
    GlobalPlace<Space> place;
    place.antenna = *report.fix;
    place.antenna_in_base = Space::from_3d(ranges.front().receiver_in_base);
    keep(place, stamp, true);
  }

  /// An error of a beacon's place is the same at all times: only those that are known well give places whose
  /// errors are independent.
  void start_buoys(TimeNs stamp) {
    constexpr double kWellKnown = 0.2;   // m
    constexpr double kStartSigma = 2.0;  // m: it need not be known well where the robot starts
    typename BeaconLocalization<Space>::Beacons beacons;
    for (const Beacon& beacon : options_.positions.beacons) {
      if (beacon.sigma > kWellKnown) continue;
      beacons[beacon.id] = {Space::from_3d(beacon.position_in_map),
                            beacon.sigma * beacon.sigma * Space::PointMatrix::Identity()};
      beacon_heights_[beacon.id] = beacon.position_in_map.z();
    }
    const InitialPoseOptions& start = options_.initial_pose;
    const double variance = kStartSigma * kStartSigma + start.position_sigma * start.position_sigma;
    buoys_.emplace(std::move(beacons), BeaconLocalizationOptions(), stamp,
                   Gaussian<Space::kPointDim>{Space::from_3d(Eigen::Vector3d(start.x, start.y, start.z)),
                                              variance * Space::PointMatrix::Identity()});
  }

  /// In the plane: the horizontal part of a range to a beacon that is higher than the receiver.
  std::optional<BeaconRange> on_a_level(BeaconRange range) const {
    const auto height = beacon_heights_.find(range.beacon);
    if (!is_usable(range) || height == beacon_heights_.end()) return std::nullopt;
    if constexpr (Space::kPointDim < 3) {
      const double rise = height->second - range.receiver_in_base.z();
      const double squared = range.range * range.range - rise * rise;
      if (!(squared > range.variance)) return std::nullopt;  // below the beacon a range tells no distance
      const double level = std::sqrt(squared);
      range.variance *= range.range * range.range / squared;
      range.range = level;
    }
    return range;
  }

  /// Of what comes often, one an interval: errors of neighbours resemble each other.
  void keep(GlobalPlace<Space> place, TimeNs stamp, bool in_map) {
    if (in_map_.value_or(in_map) != in_map) {
      ++ignored_;
      return;
    }
    in_map_ = in_map;
    if (!places_.empty()) {
      const double since_last = to_seconds(stamp - places_.back().stamp);
      if (since_last < options_.global_mapping.local_maps.path_interval) return;
      place.antenna.covariance *= correlation_inflation(since_last, options_.positions.correlation_time);
    }
    places_.push_back({stamp, place});
  }

  PipelineOptions options_;
  MotionTrack<Space> motion_;
  std::unique_ptr<LocalMaps<Space>> local_maps_;
  std::optional<BeaconLocalization<Space>> buoys_;
  std::map<int, double> beacon_heights_;  ///< m, of those that are known well
  std::vector<Stamped<GlobalPlace<Space>>> places_;
  std::optional<bool> in_map_;  ///< the frame that the positions are in
  std::size_t ignored_ = 0;
  std::optional<TimeNs> first_;      ///< of the run
  std::optional<TimeNs> last_pose_;  ///< that the local maps were told
};

}  // namespace

std::unique_ptr<GlobalMapper> make_global_mapper(const PipelineOptions& options) {
  if (options.space == SpaceType::kSpatial) return std::make_unique<SpaceMapper<Spatial>>(options);
  return std::make_unique<SpaceMapper<Planar>>(options);
}

}  // namespace kinect_ekf_slam
