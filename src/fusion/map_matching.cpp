#include "kinect_ekf_slam/fusion/map_matching.h"

#include "kinect_ekf_slam/estimators/pose_parts.h"
#include "kinect_ekf_slam/models/measurement.h"

namespace kinect_ekf_slam {
namespace {

template <class Space>
std::vector<int> landmarks_of(const SlamState<Space>& state) {
  std::vector<int> landmarks;
  for (std::size_t i = 0; i < state.infos.size(); ++i) {
    if (!is_path_point(state.infos[i])) landmarks.push_back(static_cast<int>(i));
  }
  return landmarks;
}

/// A state's landmarks, seen from its pose.
template <class Space>
class StateView : public PredictedMap<Space> {
 public:
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;

  explicit StateView(const SlamState<Space>& state) : state_(state), landmarks_(landmarks_of(state)) {
    for (const int i : landmarks_) {
      const Point point = state.landmarks_in_map.template segment<kPoint>(kPoint * i);
      const PredictedPoint<Space> predicted = predict_point<Space>(state.map_from_base, point);
      points_.push_back(predicted.point_in_base);
      by_pose_.push_back(predicted.by_pose * local_from_error<Space>(state.map_from_base));
    }
    by_landmark_ = state.map_from_base.rotation().transpose();
  }
  int size() const override { return static_cast<int>(landmarks_.size()); }
  const LandmarkInfo& info(int landmark) const override {
    return state_.infos[static_cast<std::size_t>(index(landmark))];
  }
  Point point_in_base(int landmark) const override { return points_[static_cast<std::size_t>(landmark)]; }
  PointMatrix covariance(int landmark) const override { return cross_covariance(landmark, landmark); }
  /// H_a P H_b^T.
  PointMatrix cross_covariance(int a, int b) const override {
    const Eigen::MatrixXd& P = state_.covariance;
    const auto& H_a = by_pose_[static_cast<std::size_t>(a)];
    const auto& H_b = by_pose_[static_cast<std::size_t>(b)];
    const PointMatrix by_pose = H_a * P.topLeftCorner<kPose, kPose>() * H_b.transpose();
    const PointMatrix mixed = by_landmark_ * P.block<kPoint, kPose>(row(a), 0) * H_b.transpose() +
                              H_a * P.block<kPose, kPoint>(0, row(b)) * by_landmark_.transpose();
    return by_pose + mixed +
           by_landmark_ * P.block<kPoint, kPoint>(row(a), row(b)) * by_landmark_.transpose();
  }
  /// Among the points of the state.
  int index(int landmark) const { return landmarks_[static_cast<std::size_t>(landmark)]; }

 private:
  static constexpr int kPose = Space::kPoseDim;
  static constexpr int kPoint = Space::kPointDim;
  int row(int landmark) const { return kPose + kPoint * index(landmark); }

  const SlamState<Space>& state_;
  std::vector<int> landmarks_;
  std::vector<Point> points_;
  std::vector<typename Space::PointByPose> by_pose_;
  PointMatrix by_landmark_;
};

template <class Space>
Observation<Space> as_sighting(const SlamState<Space>& state, int point) {
  constexpr int kPoint = Space::kPointDim;
  const LandmarkInfo& info = state.infos[static_cast<std::size_t>(point)];
  const int row = Space::kPoseDim + kPoint * point;
  Observation<Space> sighting;
  sighting.position_in_base = state.landmarks_in_map.template segment<kPoint>(kPoint * point);
  sighting.covariance = state.covariance.template block<kPoint, kPoint>(row, row);
  sighting.signature = {info.source_id, info.label(), info.radius, info.descriptor};
  return sighting;
}

}  // namespace

template <class Space>
std::vector<std::pair<int, int>> common_landmarks(const SlamState<Space>& first,
                                                  const SlamState<Space>& second,
                                                  const Associator<Space>& associator) {
  const StateView<Space> view(first);
  const std::vector<int> seen = landmarks_of(second);
  std::vector<Observation<Space>> sightings;
  sightings.reserve(seen.size());
  for (const int point : seen) sightings.push_back(as_sighting(second, point));
  const std::vector<Assignment> assignments = associator.associate(sightings, view);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t k = 0; k < assignments.size(); ++k) {
    if (assignments[k].verdict != Verdict::kMatched) continue;
    pairs.emplace_back(view.index(assignments[k].landmark), seen[k]);
  }
  return pairs;
}

template std::vector<std::pair<int, int>> common_landmarks<Planar>(const SlamState<Planar>&,
                                                                   const SlamState<Planar>&,
                                                                   const Associator<Planar>&);
template std::vector<std::pair<int, int>> common_landmarks<Spatial>(const SlamState<Spatial>&,
                                                                    const SlamState<Spatial>&,
                                                                    const Associator<Spatial>&);

}  // namespace kinect_ekf_slam
