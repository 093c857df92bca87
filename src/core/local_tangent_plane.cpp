#include "kinect_ekf_slam/core/local_tangent_plane.h"

#include <Eigen/Geometry>
#include <cmath>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

Eigen::Vector3d earth_centred(const Geodetic& place) {
  constexpr double kSemiMajor = 6378137.0;  // m
  constexpr double kFlattening = 1.0 / 298.257223563;
  constexpr double kSquaredEccentricity = kFlattening * (2.0 - kFlattening);
  const double latitude = radians(place.latitude_deg);
  const double longitude = radians(place.longitude_deg);
  const double sine = std::sin(latitude);
  const double normal = kSemiMajor / std::sqrt(1.0 - kSquaredEccentricity * sine * sine);
  const double from_axis = (normal + place.altitude) * std::cos(latitude);
  return {from_axis * std::cos(longitude), from_axis * std::sin(longitude),
          (normal * (1.0 - kSquaredEccentricity) + place.altitude) * sine};
}

}  // namespace

LocalTangentPlane::LocalTangentPlane(const Geodetic& datum) : origin_(earth_centred(datum)) {
  const double latitude = radians(datum.latitude_deg);
  const double longitude = radians(datum.longitude_deg);
  const Eigen::Vector3d east(-std::sin(longitude), std::cos(longitude), 0.0);
  const Eigen::Vector3d up(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                           std::sin(latitude));
  plane_from_earth_ << east.transpose(), up.cross(east).transpose(), up.transpose();
}

Eigen::Vector3d LocalTangentPlane::operator()(const Geodetic& place) const {
  return plane_from_earth_ * (earth_centred(place) - origin_);
}

}  // namespace kinect_ekf_slam
