#include "kinect_ekf_slam/mapping/state_algebra.h"

#include <Eigen/Cholesky>

#include "kinect_ekf_slam/estimators/pose_parts.h"

namespace kinect_ekf_slam {
namespace {

template <class Space>
int point_count(const SlamState<Space>& state) {
  return static_cast<int>(state.infos.size());
}

template <class Space>
int row_of(int point) {
  return Space::kPoseDim + Space::kPointDim * point;
}

template <class Space>
typename Space::Point point_of(const SlamState<Space>& state, int point) {
  return state.landmarks_in_map.template segment<Space::kPointDim>(Space::kPointDim * point);
}

Eigen::MatrixXd symmetric(const Eigen::MatrixXd& matrix) { return matrix.selfadjointView<Eigen::Lower>(); }

}  // namespace

template <class Space>
SlamState<Space> joined_states(const SlamState<Space>& first, const SlamState<Space>& second) {
  constexpr int kPose = Space::kPoseDim;
  constexpr int kPoint = Space::kPointDim;
  const typename Space::Pose& frame = first.map_from_base;
  SlamState<Space> joined;
  joined.map_from_base = frame * second.map_from_base;
  joined.infos = first.infos;
  joined.infos.insert(joined.infos.end(), second.infos.begin(), second.infos.end());
  const Eigen::Index old_points = first.landmarks_in_map.size();
  const Eigen::Index new_points = second.landmarks_in_map.size();
  joined.landmarks_in_map.resize(old_points + new_points);
  joined.landmarks_in_map.head(old_points) = first.landmarks_in_map;

  Eigen::MatrixXd by_first = Eigen::MatrixXd::Zero(kPose + old_points + new_points, kPose + old_points);
  Eigen::MatrixXd by_second = Eigen::MatrixXd::Zero(by_first.rows(), kPose + new_points);
  const ProductJacobian<Space> J(frame, second.map_from_base);
  by_first.topLeftCorner<kPose, kPose>() = J.by_left;
  by_second.topLeftCorner<kPose, kPose>() = J.by_right;
  by_first.block(kPose, kPose, old_points, old_points).setIdentity();
  for (int i = 0; i < point_count(second); ++i) {
    const typename Space::Point moved = frame * point_of(second, i);
    const Eigen::Index row = kPose + old_points + Eigen::Index{kPoint} * i;
    joined.landmarks_in_map.template segment<kPoint>(old_points + Eigen::Index{kPoint} * i) = moved;
    by_first.block<kPoint, kPose>(row, 0) = point_by_error<Space>(frame, moved);
    by_second.block<kPoint, kPoint>(row, row_of<Space>(i)) = frame.rotation();
  }
  joined.covariance = symmetric(by_first * first.covariance * by_first.transpose() +
                                by_second * second.covariance * by_second.transpose());
  return joined;
}

template <class Space>
SlamState<Space> moved_by_pose(const SlamState<Space>& state) {
  constexpr int kPose = Space::kPoseDim;
  constexpr int kPoint = Space::kPointDim;
  SlamState<Space> moved = state;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(state.covariance.rows(), state.covariance.cols());
  J.topLeftCorner<kPose, kPose>().setIdentity();
  for (int i = 0; i < point_count(state); ++i) {
    const typename Space::Point point = state.map_from_base * point_of(state, i);
    moved.landmarks_in_map.template segment<kPoint>(kPoint * i) = point;
    J.block<kPoint, kPose>(row_of<Space>(i), 0) = point_by_error<Space>(state.map_from_base, point);
    J.block<kPoint, kPoint>(row_of<Space>(i), row_of<Space>(i)) = state.map_from_base.rotation();
  }
  moved.covariance = symmetric(J * state.covariance * J.transpose());
  return moved;
}

template <class Space>
SlamState<Space> side_by_side(const SlamState<Space>& first, const SlamState<Space>& second) {
  SlamState<Space> both = first;
  both.infos.insert(both.infos.end(), second.infos.begin(), second.infos.end());
  both.landmarks_in_map.resize(first.landmarks_in_map.size() + second.landmarks_in_map.size());
  both.landmarks_in_map << first.landmarks_in_map, second.landmarks_in_map;
  const Eigen::Index old_size = first.covariance.rows();
  const Eigen::Index added = second.landmarks_in_map.size();
  both.covariance.setZero(old_size + added, old_size + added);
  both.covariance.topLeftCorner(old_size, old_size) = first.covariance;
  both.covariance.bottomRightCorner(added, added) = second.covariance.bottomRightCorner(added, added);
  return both;
}

template <class Space>
SlamState<Space> with_points(const SlamState<Space>& state, const std::vector<int>& points) {
  constexpr int kPoint = Space::kPointDim;
  std::vector<int> rows;
  rows.reserve(Space::kPoseDim);
  for (int i = 0; i < Space::kPoseDim; ++i) rows.push_back(i);
  SlamState<Space> chosen;
  chosen.map_from_base = state.map_from_base;
  chosen.landmarks_in_map.resize(kPoint * static_cast<Eigen::Index>(points.size()));
  for (std::size_t k = 0; k < points.size(); ++k) {
    chosen.infos.push_back(state.infos[static_cast<std::size_t>(points[k])]);
    chosen.landmarks_in_map.template segment<kPoint>(kPoint * static_cast<Eigen::Index>(k)) =
        point_of(state, points[k]);
    for (int axis = 0; axis < kPoint; ++axis) rows.push_back(row_of<Space>(points[k]) + axis);
  }
  const auto size = static_cast<Eigen::Index>(rows.size());
  chosen.covariance.resize(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index i = 0; i < size; ++i) {
      chosen.covariance(i, j) =
          state.covariance(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]);
    }
  }
  return chosen;
}

template <class Space>
bool merge_points(int kept, int dropped, double gate, SlamState<Space>* state) {
  constexpr int kPoint = Space::kPointDim;
  using PointMatrix = typename Space::PointMatrix;
  const int kept_row = row_of<Space>(kept);
  const int dropped_row = row_of<Space>(dropped);
  Eigen::MatrixXd weighted = state->covariance.template middleCols<kPoint>(kept_row) -
                             state->covariance.template middleCols<kPoint>(dropped_row);  // P H^T
  constexpr double kSame = 1e-6;  // m^2: how far apart the centres of one landmark's two estimates may lie
  const PointMatrix S = weighted.template middleRows<kPoint>(kept_row) -
                        weighted.template middleRows<kPoint>(dropped_row) + kSame * PointMatrix::Identity();
  const Eigen::LLT<PointMatrix> cholesky(S);
  if (cholesky.info() != Eigen::Success) return false;
  const typename Space::Point whitened =
      cholesky.matrixL().solve(point_of(*state, dropped) - point_of(*state, kept));
  if (!(whitened.squaredNorm() < gate)) return false;
  cholesky.matrixL().transpose().template solveInPlace<Eigen::OnTheRight>(weighted);
  const Eigen::VectorXd error = weighted * whitened;
  state->covariance = symmetric(state->covariance - weighted * weighted.transpose());
  state->map_from_base = moved_by_error<Space>(state->map_from_base, error.template head<Space::kPoseDim>());
  state->landmarks_in_map += error.tail(state->landmarks_in_map.size());
  state->infos[static_cast<std::size_t>(kept)].absorb(state->infos[static_cast<std::size_t>(dropped)]);
  return true;
}

#define KINECT_EKF_SLAM_INSTANTIATE(Space)                                                          \
  template SlamState<Space> joined_states<Space>(const SlamState<Space>&, const SlamState<Space>&); \
  template SlamState<Space> moved_by_pose<Space>(const SlamState<Space>&);                          \
  template SlamState<Space> side_by_side<Space>(const SlamState<Space>&, const SlamState<Space>&);  \
  template SlamState<Space> with_points<Space>(const SlamState<Space>&, const std::vector<int>&);   \
  template bool merge_points<Space>(int, int, double, SlamState<Space>*);
KINECT_EKF_SLAM_INSTANTIATE(Planar)
KINECT_EKF_SLAM_INSTANTIATE(Spatial)
#undef KINECT_EKF_SLAM_INSTANTIATE

}  // namespace kinect_ekf_slam
