#include "kinect_ekf_slam/fusion/global_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/fusion/interpolation.h"
#include "kinect_ekf_slam/fusion/map_matching.h"
#include "kinect_ekf_slam/fusion/path_spline.h"
#include "kinect_ekf_slam/mapping/state_algebra.h"

namespace kinect_ekf_slam {
namespace {

template <class Space>
using Points = std::vector<typename Space::Point>;

template <class Space>
Points<Space> points_at(const SlamState<Space>& state, const std::vector<int>& indices) {
  Points<Space> points;
  for (const int i : indices) {
    points.push_back(state.landmarks_in_map.template segment<Space::kPointDim>(Space::kPointDim * i));
  }
  return points;
}

/// A frame is told by its origin and the ends of its axes: points of these ids, so that what moves the
/// landmarks moves it with them, and its errors' correlations with theirs are kept.
constexpr int kOrigin = std::numeric_limits<int>::min();

bool is_frame_point(const LandmarkInfo& info) { return info.id <= kOrigin + 3; }
/// Where the robot was.
bool is_place(const LandmarkInfo& info) { return is_path_point(info) && !is_frame_point(info); }
bool is_landmark(const LandmarkInfo& info) { return !is_path_point(info); }

/// The state with the points of its own frame, in which they are exact.
template <class Space>
SlamState<Space> with_frame(const SlamState<Space>& state) {
  constexpr int kDim = Space::kPointDim;
  SlamState<Space> result = state;
  const Eigen::Index size = state.covariance.rows();
  constexpr int kAdded = kDim * (kDim + 1);
  result.covariance.conservativeResize(size + kAdded, size + kAdded);
  result.covariance.bottomRows(kAdded).setZero();
  result.covariance.rightCols(kAdded).setZero();
  result.landmarks_in_map.conservativeResize(state.landmarks_in_map.size() + kAdded);
  result.landmarks_in_map.tail(kAdded).setZero();
  for (int i = 0; i <= kDim; ++i) {
    if (i > 0) result.landmarks_in_map.tail(kAdded)(kDim * i + i - 1) = 1.0;  // m
    LandmarkInfo info;
    info.id = kOrigin + i;
    result.infos.push_back(info);
  }
  return result;
}

/// Where the frame is that was at `before` when its points, by their indices in the state, were made.
template <class Space>
PoseEstimate<Space> frame_of(const SlamState<Space>& state, const std::vector<int>& frame_points,
                             const typename Space::Pose& before) {
  constexpr int kDim = Space::kPointDim;
  constexpr int kTurns = Space::kTurnDim;
  const SlamState<Space> frame = with_points<Space>(state, frame_points);
  const auto point = [&](int i) { return frame.landmarks_in_map.template segment<kDim>(kDim * i); };
  TurnMatrix<Space> information = TurnMatrix<Space>::Zero();
  constexpr int kNumbers = kDim * (kDim + 1);
  Eigen::MatrixXd turn_by_points = Eigen::MatrixXd::Zero(kTurns, kNumbers);
  TurnVector<Space> pull = TurnVector<Space>::Zero();
  for (int axis = 0; axis < kDim; ++axis) {
    const typename Space::Point end = before.rotation().col(axis);
    const typename Space::PointByTurn by_turn = Space::by_turn(end);
    information += by_turn.transpose() * by_turn;
    pull += by_turn.transpose() * (point(axis + 1) - point(0) - end);
    turn_by_points.template middleCols<kDim>(kDim * (axis + 1)) = by_turn.transpose();
    turn_by_points.template leftCols<kDim>() -= by_turn.transpose();
  }
  const TurnMatrix<Space> inverse = information.inverse();
  Eigen::MatrixXd pose_by_points = Eigen::MatrixXd::Zero(Space::kPoseDim, kNumbers);
  pose_by_points.template topLeftCorner<kDim, kDim>().setIdentity();
  pose_by_points.bottomRows(kTurns) = inverse * turn_by_points;
  const Eigen::Index size = frame.landmarks_in_map.size();
  PoseEstimate<Space> pose;
  pose.map_from_base = pose_from_parts<Space>(
      point(0), turn_exp<Space>(TurnVector<Space>(inverse * pull)) * turn_of<Space>(before));
  pose.covariance =
      pose_by_points * frame.covariance.bottomRightCorner(size, size) * pose_by_points.transpose();
  return pose;
}

/// Where each local pose was, at the times of the path points.
template <class Space>
Points<Space> positions_then(const LocalMap<Space>& map) {
  Points<Space> positions;
  auto pose = map.poses.begin();
  for (const TimeNs stamp : map.path_stamps) {
    while (pose->stamp < stamp) ++pose;
    positions.push_back(pose->value.map_from_base.translation());
  }
  return positions;
}

/// The local pose at `stamp`, which the map's time holds: on the way from the look before to the one after.
template <class Space>
PoseEstimate<Space> pose_at(const LocalMap<Space>& map, TimeNs stamp) {
  const auto after = std::upper_bound(map.poses.begin(), map.poses.end(), stamp,
                                      [](TimeNs time, const auto& pose) { return time < pose.stamp; });
  if (after == map.poses.begin()) return after->value;
  const auto before = after - 1;
  if (after == map.poses.end() || before->stamp == stamp) return before->value;
  return interpolate<Space>({*before, *after}, stamp);
}

/// Where an antenna is seen from the base, in the axes of the base's map.
template <class Space>
Gaussian<Space::kPointDim> turned(const PoseEstimate<Space>& base,
                                  const typename Space::Point& antenna_in_base) {
  constexpr int kTurns = Space::kTurnDim;
  Gaussian<Space::kPointDim> offset;
  offset.mean = base.map_from_base.rotation() * antenna_in_base;
  const typename Space::PointByTurn by_turn = Space::by_turn(offset.mean);
  offset.covariance =
      by_turn * base.covariance.template bottomRightCorner<kTurns, kTurns>() * by_turn.transpose();
  return offset;
}

/// How the local frame is turned when the base is turned so in the global frame.
template <class Space>
HeadingPrior<Space> heading_by(const HeadingPrior<Space>& base_in_global, const PoseEstimate<Space>& base) {
  constexpr int kTurns = Space::kTurnDim;
  HeadingPrior<Space> heading;
  heading.global_from_local =
      turn_of<Space>(base_in_global.global_from_local) * turn_of<Space>(base.map_from_base).inverse();
  const TurnMatrix<Space> axes = turn_axes<Space>(heading.global_from_local);
  heading.covariance = base_in_global.covariance +
                       axes * base.covariance.template bottomRightCorner<kTurns, kTurns>() * axes.transpose();
  return heading;
}

template <class Space>
void keep_surer(const HeadingPrior<Space>& heading, std::optional<HeadingPrior<Space>>* surest) {
  if (!*surest || heading.covariance.trace() < (*surest)->covariance.trace()) *surest = heading;
}

/// A local map, or several joined, and where its frame lies.
template <class Space>
struct PlacedMap {
  LocalMap<Space> map;
  GlobalSegment<Space> segment;
  SlamState<Space>
      aligned;  ///< the map's state, bent by the global positions; its pose is the place of the frame
  bool follows = false;  ///< the stretch before it, which is placed as well, leads to it
  bool is_placed() const { return segment.refusal.empty(); }
};

/// Maps in the global frame whose landmarks have been found to be the same: their errors depend on each
/// other.
template <class Space>
struct Cluster {
  SlamState<Space> state;  ///< its pose means nothing
  std::vector<int> segment_of_point;
  std::vector<bool> dropped;  ///< points that are others
};

template <class Space>
class MapIntegration {
 public:
  static constexpr int kDim = Space::kPointDim;
  using Places = std::vector<Stamped<GlobalPlace<Space>>>;

  MapIntegration(const Places& places, const GlobalMapOptions& options)
      : places_(places),
        options_(options),
        merge_gate_(chi_square_quantile(options.merge_probability, kDim)) {
    AssociationOptions association = options.association;
    if (association.type == AssociationOptions::Type::kMultiHypothesis) {
      association.type = AssociationOptions::Type::kJointCompatibility;
    }
    associator_ = make_associator<Space>(association);
  }

  /// Algorithm 3, lines 17 to 22.
  GlobalMap<Space> integrate(const std::vector<LocalMap<Space>>& maps) {
    GlobalMap<Space> global;
    std::vector<PlacedMap<Space>> placed = place_all(with_fewer_places(maps));
    std::vector<Cluster<Space>> clusters;
    for (std::size_t k = 0; k < placed.size(); ++k) {
      placed[k].follows = k > 0 && placed[k - 1].is_placed() && placed[k - 1].map.leads_to_next;
      if (placed[k].is_placed()) add_to(&clusters, placed[k], static_cast<int>(k));
    }
    for (const Cluster<Space>& cluster : clusters) tell_landmarks(cluster, &global);
    for (std::size_t k = 0; k < placed.size(); ++k) {
      if (placed[k].is_placed()) tell_path(clusters, static_cast<int>(k), &placed[k]);
      global.segments.push_back(std::move(placed[k].segment));
    }
    global.merged_landmarks = merged_;
    return global;
  }

 private:
  /// Work grows with the square of the places. Between those that are kept the way is as it was in its local
  /// map.
  std::vector<LocalMap<Space>> with_fewer_places(std::vector<LocalMap<Space>> maps) const {
    std::size_t places = 0;
    for (const LocalMap<Space>& map : maps) places += map.path_stamps.size();
    const std::size_t step = 1 + places / static_cast<std::size_t>(options_.max_places);
    if (step == 1) return maps;
    for (LocalMap<Space>& map : maps) {
      const std::vector<int> path = map.path_points();
      std::vector<bool> dropped(map.state.infos.size(), false);
      std::vector<TimeNs> stamps;
      for (std::size_t i = 0; i < path.size(); ++i) {
        const bool is_kept = i % step == 0 || i + 1 == path.size();
        dropped[static_cast<std::size_t>(path[i])] = !is_kept;
        if (is_kept) stamps.push_back(map.path_stamps[i]);
      }
      std::vector<int> kept;
      for (std::size_t i = 0; i < dropped.size(); ++i) {
        if (!dropped[i]) kept.push_back(static_cast<int>(i));
      }
      map.state = with_points<Space>(map.state, kept);
      map.path_stamps = std::move(stamps);
    }
    return maps;
  }

  /// One that cannot be placed waits for the next one; the last one goes with the one before.
  std::vector<PlacedMap<Space>> place_all(const std::vector<LocalMap<Space>>& maps) {
    std::vector<PlacedMap<Space>> placed;
    for (std::size_t k = 0; k < maps.size(); ++k) {
      const int number = static_cast<int>(k);
      const bool joins =
          !placed.empty() && !placed.back().is_placed() && may_join(placed.back().map, maps[k]);
      if (joins) {
        placed.back().map = joined(placed.back().map, maps[k]);
        placed.back().segment.last_map = number;
      } else {
        placed.push_back({maps[k], {}, {}, false});
        placed.back().segment.first_map = placed.back().segment.last_map = number;
      }
      place(&placed.back());
    }
    if (placed.size() > 1 && !placed.back().is_placed() &&
        may_join(placed[placed.size() - 2].map, placed.back().map)) {
      const PlacedMap<Space> last = std::move(placed.back());
      placed.pop_back();
      placed.back().map = joined(placed.back().map, last.map);
      placed.back().segment.last_map = last.segment.last_map;
      place(&placed.back());
    }
    return placed;
  }

  /// The robot went from the one to the other, and both together are not so large that they cannot be
  /// handled.
  bool may_join(const LocalMap<Space>& first, const LocalMap<Space>& second) const {
    const std::size_t points = first.state.infos.size() + second.state.infos.size();
    return first.leads_to_next && points <= static_cast<std::size_t>(options_.max_joined_points);
  }

  /// The second map's frame is the pose at which the first one ends: what follows is the path from there.
  LocalMap<Space> joined(const LocalMap<Space>& first, const LocalMap<Space>& second) {
    const auto pairs = common_landmarks<Space>(first.state, second.state, *associator_);
    const auto offset = static_cast<int>(first.state.infos.size());
    LocalMap<Space> both = first;
    both.state = joined_states<Space>(first.state, second.state);
    std::vector<bool> dropped(both.state.infos.size(), false);
    dropped[static_cast<std::size_t>(offset) + static_cast<std::size_t>(second.path_points().front())] =
        true;  // the first one's last
    for (const auto& [old_point, new_point] : pairs) {
      if (!merge_points<Space>(old_point, offset + new_point, merge_gate_, &both.state)) continue;
      dropped[static_cast<std::size_t>(offset) + static_cast<std::size_t>(new_point)] = true;
      ++merged_;
    }
    std::vector<int> kept;
    for (std::size_t i = 0; i < dropped.size(); ++i) {
      if (!dropped[i]) kept.push_back(static_cast<int>(i));
    }
    both.state = with_points<Space>(both.state, kept);
    both.end = second.end;
    both.leads_to_next = second.leads_to_next;
    both.path_stamps.insert(both.path_stamps.end(), second.path_stamps.begin() + 1, second.path_stamps.end());
    for (const auto& pose : second.poses) {
      if (pose.stamp <= first.poses.back().stamp) continue;
      both.poses.push_back({pose.stamp, product<Space>(first.poses.back().value, pose.value)});
    }
    return both;
  }

  /// Finds the global positions of its time, and from them where the map's frame lies and how its path bends.
  void place(PlacedMap<Space>* placed) const {
    const LocalMap<Space>& map = placed->map;
    GlobalSegment<Space>& segment = placed->segment;
    segment.start = map.start;
    segment.end = map.end;
    AlignmentPairs<Space> pairs;
    std::vector<TimeNs> stamps;
    std::optional<HeadingPrior<Space>> heading;
    for (const auto& place : places_) {
      if (place.stamp < map.start || place.stamp >= map.end) continue;
      const PoseEstimate<Space> base = pose_at(map, place.stamp);
      stamps.push_back(place.stamp);
      pairs.in_global.push_back(place.value.antenna);
      pairs.offsets.push_back(turned(base, place.value.antenna_in_base));
      if (place.value.attitude) keep_surer(heading_by(*place.value.attitude, base), &heading);
    }
    segment.positions = stamps.size();
    const std::vector<int> path = map.path_points();
    const PathSpline<kDim> spline(map.path_stamps, points_at(map.state, path));
    const Eigen::MatrixXd weights = spline.weights(stamps);
    pairs.weights.setZero(weights.rows(), static_cast<Eigen::Index>(map.state.infos.size()));
    for (std::size_t j = 0; j < path.size(); ++j)
      pairs.weights.col(path[j]) = weights.col(static_cast<Eigen::Index>(j));
    pairs.local_points = map.state.landmarks_in_map;
    const Eigen::Index size = pairs.local_points.size();
    pairs.local_covariance = map.state.covariance.bottomRightCorner(size, size);

    AlignmentResult<Space> result = align_frames<Space>(pairs, options_.alignment);
    if (!result.alignment && heading) result = align_frames<Space>(pairs, options_.alignment, heading);
    segment.refusal = result.refusal;
    if (!result.alignment) return;
    segment.global_from_local = result.alignment->global_from_local;
    segment.disagreements.clear();
    for (const Disagreement<Space>& disagreement : result.alignment->disagreements) {
      segment.disagreements.push_back({stamps[disagreement.pair], disagreement});
    }
    placed->aligned = {segment.global_from_local.map_from_base, map.state.infos,
                       std::move(result.alignment->local_points), std::move(result.alignment->covariance)};
  }

  /// Adds one map. Clusters that have a landmark of it, or the stretch of the way that leads to it, become
  /// one with it.
  void add_to(std::vector<Cluster<Space>>* clusters, const PlacedMap<Space>& placed, int number) {
    const SlamState<Space>& local = placed.aligned;
    Cluster<Space> added;
    added.state = moved_by_pose<Space>(with_frame<Space>(local));
    added.segment_of_point.assign(added.state.infos.size(), number);
    added.dropped.assign(added.state.infos.size(), false);
    int offset = 0;  // of the map's own points
    std::vector<Cluster<Space>> others;
    for (Cluster<Space>& cluster : *clusters) {
      const auto pairs = common_with(cluster, local);
      const std::optional<int> place_before = placed.follows ? last_place(cluster, number - 1) : std::nullopt;
      if (pairs.empty() && !place_before) {
        others.push_back(std::move(cluster));
        continue;
      }
      const int cluster_size = static_cast<int>(cluster.state.infos.size());
      cluster.state = side_by_side<Space>(cluster.state, added.state);
      const auto append = [](const auto& more, auto* list) {
        list->insert(list->end(), more.begin(), more.end());
      };
      append(added.segment_of_point, &cluster.segment_of_point);
      append(added.dropped, &cluster.dropped);
      added = std::move(cluster);
      offset += cluster_size;
      for (const auto& [old_point, own_point] : pairs) {
        if (!merge_points<Space>(offset + own_point, old_point, merge_gate_, &added.state)) continue;
        added.dropped[static_cast<std::size_t>(old_point)] = true;
        ++merged_;
      }
      if (place_before) {
        const int first_place = placed.map.path_points().front();
        merge_points<Space>(offset + first_place, *place_before, merge_gate_, &added.state);
      }
    }
    others.push_back(std::move(added));
    *clusters = std::move(others);
  }

  /// Where the segment's path ends, as a point of the cluster; nothing when it is in another cluster.
  static std::optional<int> last_place(const Cluster<Space>& cluster, int segment) {
    std::optional<int> last;
    for (std::size_t i = 0; i < cluster.state.infos.size(); ++i) {
      const bool is_of_path = cluster.segment_of_point[i] == segment && is_place(cluster.state.infos[i]);
      if (is_of_path) last = static_cast<int>(i);
    }
    return last;
  }

  /// The cluster's landmarks that the map has too, by their indices in both.
  std::vector<std::pair<int, int>> common_with(const Cluster<Space>& cluster,
                                               const SlamState<Space>& local) const {
    std::vector<int> landmarks;
    for (std::size_t i = 0; i < cluster.state.infos.size(); ++i) {
      if (!cluster.dropped[i] && is_landmark(cluster.state.infos[i]))
        landmarks.push_back(static_cast<int>(i));
    }
    SlamState<Space> seen_from_frame = with_points<Space>(cluster.state, landmarks);
    constexpr int kPose = Space::kPoseDim;
    seen_from_frame.map_from_base = local.map_from_base;
    seen_from_frame.covariance.topRows(kPose).setZero();
    seen_from_frame.covariance.leftCols(kPose).setZero();
    seen_from_frame.covariance.template topLeftCorner<kPose, kPose>() =
        local.covariance.template topLeftCorner<kPose, kPose>();
    auto pairs = common_landmarks<Space>(seen_from_frame, local, *associator_);
    for (auto& pair : pairs) pair.first = landmarks[static_cast<std::size_t>(pair.first)];
    return pairs;
  }

  void tell_landmarks(const Cluster<Space>& cluster, GlobalMap<Space>* global) const {
    for (std::size_t i = 0; i < cluster.state.infos.size(); ++i) {
      if (cluster.dropped[i] || !is_landmark(cluster.state.infos[i])) continue;
      const auto point = static_cast<Eigen::Index>(i);
      const Eigen::Index row = Space::kPoseDim + kDim * point;
      LandmarkEstimate<Space> landmark;
      landmark.info = cluster.state.infos[i];
      const bool is_named = associator_->knows_identities() && landmark.info.source_id != kNoId;
      landmark.info.id = is_named ? landmark.info.source_id : static_cast<int>(global->landmarks.size());
      landmark.position_in_map = cluster.state.landmarks_in_map.template segment<kDim>(kDim * point);
      landmark.covariance = cluster.state.covariance.template block<kDim, kDim>(row, row);
      global->landmarks.push_back(std::move(landmark));
      global->segment_of_landmark.push_back(cluster.segment_of_point[i]);
    }
  }

  /// The spline through the path points as they are known now carries what the filter's poses were besides.
  void tell_path(const std::vector<Cluster<Space>>& clusters, int number, PlacedMap<Space>* placed) const {
    const auto cluster = std::find_if(clusters.begin(), clusters.end(), [&](const Cluster<Space>& candidate) {
      return std::count(candidate.segment_of_point.begin(), candidate.segment_of_point.end(), number) > 0;
    });
    std::vector<int> path;
    std::vector<int> frame_points;
    for (std::size_t i = 0; i < cluster->state.infos.size(); ++i) {
      if (cluster->segment_of_point[i] != number) continue;
      if (is_place(cluster->state.infos[i])) path.push_back(static_cast<int>(i));
      if (is_frame_point(cluster->state.infos[i])) frame_points.push_back(static_cast<int>(i));
    }
    PoseEstimate<Space>& frame = placed->segment.global_from_local;
    frame = frame_of<Space>(cluster->state, frame_points, frame.map_from_base);
    const LocalMap<Space>& map = placed->map;
    const PathSpline<kDim> now(map.path_stamps, points_at(cluster->state, path));
    const PathSpline<kDim> then(map.path_stamps, positions_then(map));
    std::vector<TimeNs> stamps;
    for (const auto& pose : map.poses) stamps.push_back(pose.stamp);
    const Eigen::MatrixXd weights = now.weights(stamps);
    const Eigen::MatrixXd spreads =
        spreads_on_path(weights, with_points<Space>(cluster->state, path).covariance);
    placed->segment.path.clear();
    for (std::size_t k = 0; k < map.poses.size(); ++k) {
      PoseEstimate<Space> pose = product<Space>(frame, map.poses[k].value);
      const typename Space::Point detail =
          map.poses[k].value.map_from_base.translation() - then.position(stamps[k]);
      const typename Space::Point position =
          now.position(stamps[k]) + frame.map_from_base.rotation() * detail;
      pose.map_from_base = pose_from_parts<Space>(position, turn_of<Space>(pose.map_from_base));
      pose.covariance.template topRows<kDim>().setZero();
      pose.covariance.template leftCols<kDim>().setZero();
      pose.covariance.template topLeftCorner<kDim, kDim>() =
          spreads.template middleRows<kDim>(kDim * static_cast<Eigen::Index>(k));
      placed->segment.path.push_back({stamps[k], pose});
    }
  }

  /// W P W^T of each time, one below the other, equation (13.3); all times at once, an axis against an axis.
  static Eigen::MatrixXd spreads_on_path(const Eigen::MatrixXd& weights, const Eigen::MatrixXd& covariance) {
    const Eigen::Index points = weights.cols();
    Eigen::MatrixXd spreads(kDim * weights.rows(), kDim);
    Eigen::MatrixXd between(points, points);
    for (int a = 0; a < kDim; ++a) {
      for (int b = 0; b <= a; ++b) {
        for (Eigen::Index j = 0; j < points; ++j) {
          for (Eigen::Index i = 0; i < points; ++i) {
            between(i, j) = covariance(Space::kPoseDim + kDim * i + a, Space::kPoseDim + kDim * j + b);
          }
        }
        const Eigen::VectorXd spread = (weights * between).cwiseProduct(weights).rowwise().sum();
        for (Eigen::Index k = 0; k < weights.rows(); ++k) {
          spreads(kDim * k + a, b) = spreads(kDim * k + b, a) = spread(k);
        }
      }
    }
    return spreads;
  }

  const Places& places_;
  const GlobalMapOptions& options_;
  double merge_gate_;
  std::unique_ptr<Associator<Space>> associator_;
  int merged_ = 0;
};

}  // namespace

template <class Space>
GlobalMap<Space> integrate_maps(const std::vector<LocalMap<Space>>& maps,
                                const std::vector<Stamped<GlobalPlace<Space>>>& places,
                                const GlobalMapOptions& options) {
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (places[i].stamp < places[i - 1].stamp) {
      throw std::invalid_argument("global positions: time goes back by " +
                                  std::to_string(to_seconds(places[i - 1].stamp - places[i].stamp)) +
                                  " s at position " + std::to_string(i) + ", they must ascend");
    }
  }
  return MapIntegration<Space>(places, options).integrate(maps);
}

template GlobalMap<Planar> integrate_maps<Planar>(const std::vector<LocalMap<Planar>>&,
                                                  const std::vector<Stamped<GlobalPlace<Planar>>>&,
                                                  const GlobalMapOptions&);
template GlobalMap<Spatial> integrate_maps<Spatial>(const std::vector<LocalMap<Spatial>>&,
                                                    const std::vector<Stamped<GlobalPlace<Spatial>>>&,
                                                    const GlobalMapOptions&);

}  // namespace kinect_ekf_slam
