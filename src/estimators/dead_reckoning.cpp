#include "kinect_ekf_slam/estimators/dead_reckoning.h"

#include <algorithm>
#include <tuple>

namespace kinect_ekf_slam {

/// What the associator sees: the landmarks where they were plotted, as uncertain as the sighting was.
template <class Space>
class DeadReckoning<Space>::Prediction : public PredictedMap<Space> {
 public:
  explicit Prediction(const DeadReckoning& open_loop) : open_loop_(open_loop) {}
  int size() const override { return static_cast<int>(open_loop_.landmarks_.size()); }
  const LandmarkInfo& info(int landmark) const override { return open_loop_.landmarks_[landmark].info; }
  typename Space::Point point_in_base(int landmark) const override {
    return predicted(landmark).point_in_base;
  }
  typename Space::PointMatrix covariance(int landmark) const override {
    const auto rotation = predicted(landmark).by_landmark;
    return rotation * open_loop_.landmarks_[landmark].covariance * rotation.transpose();
  }

 private:
  PredictedPoint<Space> predicted(int landmark) const {
    return predict_point<Space>(open_loop_.pose_.map_from_base,
                                open_loop_.landmarks_[landmark].position_in_map);
  }
  const DeadReckoning& open_loop_;
};

namespace {

/// An identity is obeyed: without correction the gate only tells how far the open loop has drifted. Of
/// several sightings of one landmark the one that fits best counts.
void obey_identities(std::vector<Assignment>* assignments) {
  const std::vector<Assignment> given = *assignments;
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (given[k].verdict != Verdict::kOutsideGate) continue;
    bool is_best = true;
    for (std::size_t other = 0; other < given.size(); ++other) {
      if (other == k || given[other].landmark != given[k].landmark) continue;
      const bool is_rival =
          given[other].verdict == Verdict::kOutsideGate &&
          std::tie(given[other].squared_distance, other) < std::tie(given[k].squared_distance, k);
      if (given[other].verdict == Verdict::kMatched || is_rival) is_best = false;
    }
    (*assignments)[k].verdict = is_best ? Verdict::kMatched : Verdict::kDuplicateIdentity;
  }
}

}  // namespace

template <class Space>
void DeadReckoning<Space>::predict(const MotionStep<Space>& step) {
  predict_pose(step, &pose_);
}

template <class Space>
UpdateReport DeadReckoning<Space>::observe(TimeNs stamp,
                                           const std::vector<Observation<Space>>& observations) {
  UpdateReport report;
  report.assignments = associator_->associate(observations, Prediction(*this));
  obey_identities(&report.assignments);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    Assignment& assignment = report.assignments[k];
    if (assignment.verdict == Verdict::kCreated) {
      if (map_fixed_) {
        assignment.verdict = Verdict::kNotInMap;
      } else if (static_cast<int>(landmarks_.size()) >= options_.max_landmarks) {
        assignment.verdict = Verdict::kMapFull;
      } else {
        assignment.landmark = static_cast<int>(landmarks_.size());
        landmarks_.emplace_back();
        landmarks_.back().info.id = ids_.next(observations[k].signature);
      }
    }
    if (is_accepted(assignment.verdict) && !map_fixed_) {
      LandmarkEstimate<Space>& landmark = landmarks_[assignment.landmark];
      const typename Space::Pose& map_from_base = pose_.map_from_base;
      const auto seen = predict_point<Space>(map_from_base, map_from_base * observations[k].position_in_base);
      const typename Space::PointMatrix rotation = seen.by_landmark.transpose();
      const typename Space::PointMatrix turned = rotation * observations[k].covariance * rotation.transpose();
      landmark.info.add(stamp, observations[k].signature);
      landmark.position_in_map = map_from_base * observations[k].position_in_base;
      landmark.covariance = turned.template selfadjointView<Eigen::Lower>();
    }
    if (assignment.landmark >= 0) assignment.landmark = landmarks_[assignment.landmark].info.id;
  }
  return report;
}

template <class Space>
SlamState<Space> DeadReckoning<Space>::snapshot() const {
  constexpr int kPoseDim = Space::kPoseDim;
  constexpr int kPointDim = Space::kPointDim;
  const int points = kPointDim * static_cast<int>(landmarks_.size());
  SlamState<Space> state;
  state.map_from_base = pose_.map_from_base;
  state.landmarks_in_map.resize(points);
  state.covariance.setZero(kPoseDim + points, kPoseDim + points);
  state.covariance.template topLeftCorner<kPoseDim, kPoseDim>() = pose_.covariance;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const int row = kPointDim * static_cast<int>(i);
    state.infos.push_back(landmarks_[i].info);
    state.landmarks_in_map.template segment<kPointDim>(row) = landmarks_[i].position_in_map;
    state.covariance.template block<kPointDim, kPointDim>(kPoseDim + row, kPoseDim + row) =
        landmarks_[i].covariance;
  }
  return state;
}

template <class Space>
void DeadReckoning<Space>::restore(const SlamState<Space>& state) {
  constexpr int kPoseDim = Space::kPoseDim;
  constexpr int kPointDim = Space::kPointDim;
  pose_ = {state.map_from_base, state.covariance.template topLeftCorner<kPoseDim, kPoseDim>()};
  landmarks_.clear();
  ids_.clear();
  for (std::size_t i = 0; i < state.infos.size(); ++i) {
    const int row = kPointDim * static_cast<int>(i);
    landmarks_.push_back(
        {state.infos[i], state.landmarks_in_map.template segment<kPointDim>(row),
         state.covariance.template block<kPointDim, kPointDim>(kPoseDim + row, kPoseDim + row)});
    ids_.take(state.infos[i].id);
  }
}

template class DeadReckoning<Planar>;
template class DeadReckoning<Spatial>;

}  // namespace kinect_ekf_slam
