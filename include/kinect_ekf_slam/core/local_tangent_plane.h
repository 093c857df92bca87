#pragma once

#include <Eigen/Core>

namespace kinect_ekf_slam {

/// A place on the Earth as GPS tells it (WGS 84).
struct Geodetic {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude = 0.0;  ///< m above the ellipsoid
};

/// The plane that touches the Earth at a datum: x east, y north, z up, m (REP-103's ENU). Exact, by way of
/// the Earth-centred axes (Hofmann-Wellenhof, Lichtenegger, Collins, "GPS Theory and Practice",
/// section 10.2).
class LocalTangentPlane {
 public:
  explicit LocalTangentPlane(const Geodetic& datum);
  Eigen::Vector3d operator()(const Geodetic& place) const;

 private:
  Eigen::Vector3d origin_;  ///< of the datum, Earth-centred
  Eigen::Matrix3d plane_from_earth_;
};

}  // namespace kinect_ekf_slam
