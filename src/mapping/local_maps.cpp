#include "kinect_ekf_slam/mapping/local_maps.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/mapping/state_algebra.h"

namespace kinect_ekf_slam {
namespace {

/// The map as sightings are compared with it: without the path points.
template <class Space>
class LandmarksAlone : public PredictedMap<Space> {
 public:
  explicit LandmarksAlone(const PredictedMap<Space>& all) : all_(all) {
    for (int i = 0; i < all.size(); ++i) {
      if (!is_path_point(all.info(i))) landmarks_.push_back(i);
    }
  }
  int size() const override { return static_cast<int>(landmarks_.size()); }
  const LandmarkInfo& info(int landmark) const override { return all_.info(index(landmark)); }
  typename Space::Point point_in_base(int landmark) const override {
    return all_.point_in_base(index(landmark));
  }
  typename Space::PointMatrix covariance(int landmark) const override {
    return all_.covariance(index(landmark));
  }
  typename Space::PointMatrix cross_covariance(int a, int b) const override {
    return all_.cross_covariance(index(a), index(b));
  }
  /// In the map with the path points.
  int index(int landmark) const { return landmarks_[static_cast<std::size_t>(landmark)]; }

 private:
  const PredictedMap<Space>& all_;
  std::vector<int> landmarks_;
};

}  // namespace

template <class Space>
LocalMaps<Space>::LocalMaps(const LocalMapOptions& options, MakeMap make_map,
                            std::shared_ptr<const Associator<Space>> associator,
                            const PoseEstimate<Space>& initial)
    : options_(options),
      make_map_(std::move(make_map)),
      associator_(std::move(associator)),
      map_from_local_(initial) {
  start_map();
}

template <class Space>
LocalMaps<Space>::LocalMaps(const LocalMaps& other)
    : SlamEstimator<Space>(other),
      options_(other.options_),
      make_map_(other.make_map_),
      associator_(other.associator_),
      closed_(other.closed_),
      map_from_local_(other.map_from_local_),
      map_(std::make_unique<ManagedMap<Space>>(*other.map_)),
      present_(other.present_),
      started_(other.started_),
      held_(other.held_),
      last_held_(other.last_held_) {}

/// The frame is the robot's pose now: nothing in it is uncertain yet.
template <class Space>
void LocalMaps<Space>::start_map() {
  PoseEstimate<Space> here;
  constexpr double kExact = 1e-12;  // m^2, rad^2
  here.covariance.diagonal().setConstant(kExact);
  map_ = make_map_(here);
  present_ = LocalMap<Space>();
  started_ = false;
  held_ = false;
}

template <class Space>
void LocalMaps<Space>::start_time(TimeNs stamp) {
  if (started_) return;
  present_.start = stamp;
  started_ = true;
}

template <class Space>
UpdateReport LocalMaps<Space>::observe(TimeNs stamp, const Observations& observations) {
  start_time(stamp);
  const auto all = map_->expect(observations);
  const LandmarksAlone<Space> landmarks(all);
  std::vector<Assignment> assignments = associator_->associate(observations, landmarks);
  int matched = 0;
  for (Assignment& assignment : assignments) {
    if (assignment.verdict == Verdict::kMatched) ++matched;
    const bool is_index = assignment.landmark >= 0 && assignment.verdict != Verdict::kCreated;
    if (is_index) assignment.landmark = landmarks.index(assignment.landmark);
  }
  UpdateReport report = map_->apply(stamp, observations, std::move(assignments));
  if (matched >= options_.min_matches) {
    held_ = true;
    last_held_ = stamp;
  }
  keep_pose(stamp);
  return report;
}

template <class Space>
void LocalMaps<Space>::go_on(TimeNs stamp) {
  start_time(stamp);
  keep_pose(stamp);
}

template <class Space>
void LocalMaps<Space>::keep_pose(TimeNs stamp) {
  present_.end = stamp;
  present_.poses.push_back({stamp, map_->pose()});
  const auto& kept = present_.path_stamps;
  if (kept.empty() || to_seconds(stamp - kept.back()) >= options_.path_interval) keep_place(stamp);
  if (is_over(stamp)) {
    close_map();
    present_.start = present_.end = stamp;  // the next map starts where this one ends
    started_ = true;
    present_.poses.push_back({stamp, map_->pose()});
    keep_place(stamp);
  }
}

template <class Space>
void LocalMaps<Space>::keep_place(TimeNs stamp) {
  map_->keep_position(stamp, kFirstPathPoint - static_cast<int>(present_.path_stamps.size()));
  present_.path_stamps.push_back(stamp);
}

template <class Space>
bool LocalMaps<Space>::is_over(TimeNs stamp) const {
  const bool is_lost = held_ && to_seconds(stamp - last_held_) > options_.gap_time;
  const bool is_full = static_cast<int>(present_.path_stamps.size()) >= options_.max_path_points;
  return is_lost || is_full || is_too_uncertain();
}

template <class Space>
bool LocalMaps<Space>::is_too_uncertain() const {
  const auto sigma = [](const auto& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance, Eigen::EigenvaluesOnly);
    return std::sqrt(axes.eigenvalues().maxCoeff());
  };
  const typename Space::PoseMatrix covariance = map_->pose().covariance;
  constexpr int kPoints = Space::kPointDim;
  constexpr int kTurns = Space::kTurnDim;
  return sigma(covariance.template topLeftCorner<kPoints, kPoints>()) > options_.max_position_sigma ||
         sigma(covariance.template bottomRightCorner<kTurns, kTurns>()) >
             radians(options_.max_turn_sigma_deg);
}

template <class Space>
void LocalMaps<Space>::close_map() {
  if (present_.path_stamps.back() != present_.end) keep_place(present_.end);
  closed_.push_back(closed());
  map_from_local_ = pose();
  start_map();
}

template <class Space>
LocalMap<Space> LocalMaps<Space>::closed() const {
  LocalMap<Space> map = present_;
  map.state = map_->snapshot();
  return map;
}

template <class Space>
std::vector<LocalMap<Space>> LocalMaps<Space>::maps() const {
  LocalMaps copy(*this);
  if (copy.started_ && copy.present_.end > copy.present_.start) copy.close_map();
  return std::move(copy.closed_);
}

template <class Space>
std::vector<LandmarkEstimate<Space>> LocalMaps<Space>::landmarks() const {
  std::vector<LandmarkEstimate<Space>> landmarks;
  for (LandmarkEstimate<Space>& landmark : map_->landmarks()) {
    if (is_path_point(landmark.info)) continue;
    const typename Space::Pose& transform = map_from_local_.map_from_base;
    landmark.position_in_map = transform * landmark.position_in_map;
    const auto by_frame = point_by_error<Space>(transform, landmark.position_in_map);
    const typename Space::PointMatrix turned =
        transform.rotation() * landmark.covariance * transform.rotation().transpose() +
        by_frame * map_from_local_.covariance * by_frame.transpose();
    landmark.covariance = turned.template selfadjointView<Eigen::Lower>();
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

template <class Space>
SlamState<Space> LocalMaps<Space>::snapshot() const {
  SlamState<Space> state;
  state.map_from_base = map_from_local_.map_from_base;
  state.covariance = map_from_local_.covariance;
  state.landmarks_in_map.resize(0);
  const SlamState<Space> present = map_->snapshot();
  std::vector<int> landmarks;
  for (std::size_t i = 0; i < present.infos.size(); ++i) {
    if (!is_path_point(present.infos[i])) landmarks.push_back(static_cast<int>(i));
  }
  return joined_states<Space>(state, with_points<Space>(present, landmarks));
}

template <class Space>
void LocalMaps<Space>::restore(const SlamState<Space>& state) {
  if (started_ && present_.end > present_.start) close_map();
  if (!closed_.empty()) closed_.back().leads_to_next = false;
  start_map();
  map_from_local_ = {};
  map_->restore(state);
}

template <class Space>
void LocalMaps<Space>::set_pose(const PoseEstimate<Space>& pose) {
  if (started_ && present_.end > present_.start) close_map();
  if (!closed_.empty()) closed_.back().leads_to_next = false;
  start_map();
  map_from_local_ = pose;
}

template class LocalMaps<Planar>;
template class LocalMaps<Spatial>;

}  // namespace kinect_ekf_slam
