#pragma once

#include <ceres/jet.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/space.h"

namespace kinect_ekf_slam {

/// Rotations of a space over a scalar that Ceres differentiates. `numbers` are those that follow the
/// translation in Space::to_vector.
template <class Space>
struct Turn;

template <>
struct Turn<Planar> {
  template <class T>
  using Rotation = Eigen::Rotation2D<T>;
  template <class T>
  using Vector = Eigen::Matrix<T, Planar::kTurnDim, 1>;

  template <class T>
  static Rotation<T> from_numbers(const T* numbers) {
    return Rotation<T>(numbers[0]);
  }
  template <class T>
  static Rotation<T> exp(const Vector<T>& vector) {
    return Rotation<T>(vector(0));
  }
  /// Angle in [-pi, pi).
  template <class T>
  static Vector<T> log(const Rotation<T>& rotation) {
    using std::floor;
    const T turns = floor((rotation.angle() + T(kPi)) / T(2.0 * kPi));
    return Vector<T>(rotation.angle() - T(2.0 * kPi) * turns);
  }
};

template <>
struct Turn<Spatial> {
  template <class T>
  using Rotation = Eigen::Quaternion<T>;
  template <class T>
  using Vector = Eigen::Matrix<T, Spatial::kTurnDim, 1>;

  template <class T>
  static Rotation<T> from_numbers(const T* numbers) {
    return Rotation<T>(numbers[3], numbers[0], numbers[1], numbers[2]);
  }
  template <class T>
  static Rotation<T> exp(const Vector<T>& vector) {
    T wxyz[4];
    ceres::AngleAxisToQuaternion(vector.data(), wxyz);
    return Rotation<T>(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  }
  template <class T>
  static Vector<T> log(const Rotation<T>& rotation) {
    const T wxyz[4] = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
    Vector<T> vector;
    ceres::QuaternionToAngleAxis(wxyz, vector.data());
    return vector;
  }
};

/// A pose of the space over a scalar that Ceres differentiates.
template <class Space, class T>
struct DifferentiablePose {
  using Point = Eigen::Matrix<T, Space::kPointDim, 1>;
  using Rotation = typename Turn<Space>::template Rotation<T>;

  Point translation;
  Rotation rotation;

  /// From the numbers of Space::to_vector.
  static DifferentiablePose from_numbers(const T* numbers) {
    return {Eigen::Map<const Point>(numbers),
            Turn<Space>::template from_numbers<T>(numbers + Space::kPointDim)};
  }
  static DifferentiablePose from(const typename Space::Pose& pose) {
    const Eigen::Matrix<T, Eigen::Dynamic, 1> numbers = Space::to_vector(pose).template cast<T>();
    return from_numbers(numbers.data());
  }
  /// A small motion: straight, then turned.
  template <class Vector>
  static DifferentiablePose small(const Vector& tangent) {
    const typename Turn<Space>::template Vector<T> turn = tangent.template tail<Space::kTurnDim>();
    return {tangent.template head<Space::kPointDim>(), Turn<Space>::template exp<T>(turn)};
  }
  /// What `small` makes it from.
  Eigen::Matrix<T, Space::kPoseDim, 1> as_small() const {
    Eigen::Matrix<T, Space::kPoseDim, 1> tangent;
    tangent << translation, Turn<Space>::template log<T>(rotation);
    return tangent;
  }

  DifferentiablePose inverse() const {
    const Rotation back = rotation.inverse();
    return {-(back * translation), back};
  }
  DifferentiablePose operator*(const DifferentiablePose& other) const {
    return {*this * other.translation, rotation * other.rotation};
  }
  Point operator*(const Point& point) const { return rotation * point + translation; }
};

}  // namespace kinect_ekf_slam
