#pragma once

#include <Eigen/Core>
#include <optional>

#include "kinect_ekf_slam/core/position.h"
#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// A measurement seen from an estimate: its innovation and how h(x, l) changes there. Each has a row for each
/// number measured.
template <class Space>
struct ExpectedMeasurement {
  static constexpr int kMostRows = Space::kPoseDim;
  template <int Cols>
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Cols, Eigen::ColMajor, kMostRows, Cols>;

  Rows<1> innovation;               ///< nu = z - h(x, l)
  Rows<Space::kPoseDim> by_pose;    ///< dh by a local perturbation pose * Exp(xi)
  Rows<Space::kPointDim> by_point;  ///< dh by the point
  /// Where one number is measured and h bends: W, with W^T W the second derivative of h by (pose, point).
  struct Bend {
    typename Space::PointByPose by_pose;
    typename Space::PointMatrix by_point;
  };
  std::optional<Bend> bend;
};

/// What tells where the robot is, other than a sighting: z = h(x, l) + v, v ~ N(0, R). The point l is a
/// beacon's place, where the measurement has to do with one.
template <class Space>
class PoseMeasurement {
 public:
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;
  virtual ~PoseMeasurement() = default;

  /// Nothing where h has no derivative. `point` counts where the measurement depends on one.
  virtual std::optional<ExpectedMeasurement<Space>> expect(const Pose& map_from_base,
                                                           const Point& point_in_map) const = 0;
  /// R, in the units of the innovation.
  virtual Eigen::MatrixXd noise() const = 0;
};

/// h = |l - (p + R a)|: the distance of a beacon from the receiver a (docs/theory.md, section 11).
///
/// In the plane both may stand at different heights: `height` m between them, the hypotenuse is measured.
template <class Space>
class RangeMeasurement : public PoseMeasurement<Space> {
 public:
  using typename PoseMeasurement<Space>::Pose;
  using typename PoseMeasurement<Space>::Point;
  /// `beacon_height` m in the map; it has no meaning in space, where the point has a height.
  RangeMeasurement(const BeaconRange& measured, double beacon_height);

  double expected_range(const Pose& map_from_base, const Point& beacon_in_map) const;
  /// Nothing where the range is zero: the beacon then lies in every direction.
  std::optional<ExpectedMeasurement<Space>> expect(const Pose& map_from_base,
                                                   const Point& beacon_in_map) const override;
  Eigen::MatrixXd noise() const override { return Eigen::MatrixXd::Constant(1, 1, variance_); }

 private:
  Point receiver_in_base_;
  double height_ = 0.0;
  double range_;
  double variance_;
};

/// h = p + R a, the place of an antenna a, and the attitude R where that is measured too (docs/theory.md,
/// section 11). The error of an attitude is a turn about the axes of the base.
template <class Space>
class PositionMeasurement : public PoseMeasurement<Space> {
 public:
  using typename PoseMeasurement<Space>::Pose;
  using typename PoseMeasurement<Space>::Point;
  explicit PositionMeasurement(const GlobalPosition& measured);

  /// Always there; `point` is not used.
  std::optional<ExpectedMeasurement<Space>> expect(const Pose& map_from_base,
                                                   const Point& point = Point::Zero()) const override;
  Eigen::MatrixXd noise() const override { return noise_; }

 private:
  Pose measured_;  ///< without an attitude, only its translation means something
  bool has_attitude_;
  Point antenna_in_base_;
  Eigen::MatrixXd noise_;
};

}  // namespace kinect_ekf_slam
