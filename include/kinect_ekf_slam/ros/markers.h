#pragma once

#include <geometry_msgs/Point.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

#include "kinect_ekf_slam/pipeline/global_mapper.h"
#include "kinect_ekf_slam/pipeline/options.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// Half axes (m) and heading (rad) of the ellipse that holds the points within `sigmas` of a 2-D Gaussian.
struct Ellipse {
  double major = 0.0;
  double minor = 0.0;
  double heading = 0.0;
};

/// Throws std::invalid_argument for a covariance that is not finite or not positive semi-definite.
Ellipse ellipse(const Eigen::Matrix2d& covariance, double sigmas);

/// Half axes (m) of the ellipsoid that holds the points within `sigmas` of a 3-D Gaussian, the longest last.
struct Ellipsoid {
  Eigen::Vector3d half_axes = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< their directions as columns: a rotation
};

/// Throws std::invalid_argument likewise.
Ellipsoid ellipsoid(const Eigen::Matrix3d& covariance, double sigmas);

/// The colour of a label: its own where it names one, else one that stays the same for the same label.
std_msgs::ColorRGBA label_color(const std::string& label);

/// What RViz shows of one moment.
struct MarkerScene {
  std::vector<Landmark3d> map;
  Pose3d pose;
  std::vector<DetectionOutcome> outcomes;  ///< of the last frame with detections
  std::vector<geometry_msgs::Point> path;
  std::vector<geometry_msgs::Point> dead_reckoned_path;
  std::vector<Landmark3d> beacons{};
};

/// Turns scenes into markers; remembers which landmarks are shown, to remove those that have gone. In the
/// plane landmarks are cylinders that stand on flat ellipses, in space balls in ellipsoids; beacons are
/// cubes. What is not confirmed yet is faint, and a question mark ends its name.
class MarkerPainter {
 public:
  MarkerPainter(std::string frame_id, double sigmas, SpaceType space = SpaceType::kPlanar)
      : frame_id_(std::move(frame_id)), sigmas_(sigmas), space_(space) {}

  visualization_msgs::MarkerArray paint(const MarkerScene& scene);
  /// Its landmarks, each stretch of the way in a colour of its own, the positions, and red lines to those
  /// that were left out. What was painted before goes.
  visualization_msgs::MarkerArray paint_global(const GlobalMap3d& map);
  /// Removes everything that was ever painted.
  visualization_msgs::MarkerArray clear();

  void set_sigmas(double sigmas) { sigmas_ = sigmas; }
  void set_frame(const std::string& frame_id) { frame_id_ = frame_id; }

 private:
  visualization_msgs::Marker marker(const std::string& space, int id, int type) const;
  visualization_msgs::Marker body_of(const Landmark3d& landmark) const;
  visualization_msgs::Marker spread(const std::string& space, int id, const Eigen::Vector3d& position_in_map,
                                    const Eigen::Matrix3d& covariance) const;
  bool is_planar() const { return space_ == SpaceType::kPlanar; }
  void paint_landmarks(const std::vector<Landmark3d>& map, visualization_msgs::MarkerArray* array);
  void paint_beacons(const MarkerScene& scene, visualization_msgs::MarkerArray* array) const;
  void paint_robot(const MarkerScene& scene, visualization_msgs::MarkerArray* array) const;
  void paint_associations(const MarkerScene& scene, visualization_msgs::MarkerArray* array) const;
  void paint_path(const std::string& space, const std::vector<geometry_msgs::Point>& points, double width,
                  const std_msgs::ColorRGBA& color, visualization_msgs::MarkerArray* array) const;

  std::string frame_id_;
  double sigmas_;
  SpaceType space_;
  ros::Time stamp_;
  std::set<int> shown_;
};

}  // namespace kinect_ekf_slam
