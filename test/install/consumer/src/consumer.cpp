// Maps one landmark with the installed libraries, and puts the map into the installed message.
#include <kinect_ekf_slam/LandmarkMap.h>
#include <kinect_ekf_slam/perception/fiducial.h>
#include <kinect_ekf_slam/pipeline/slam_pipeline.h>
#include <kinect_ekf_slam/ros/conversions.h>

#include <cstdio>

int main() {
  using namespace kinect_ekf_slam;
  const auto pipeline = make_pipeline(PipelineOptions{});
  SensorFrame frame;
  frame.stamp = to_nanoseconds(1.0);
  Detection detection;
  detection.position_in_base = Eigen::Vector3d(1.5, 0.2, 0.3);
  detection.position_in_optical = Eigen::Vector3d(-0.2, 0.0, 1.5);
  detection.covariance_in_base = 1e-4 * Eigen::Matrix3d::Identity();
  frame.detections = {detection};
  pipeline->process(frame);

  const LandmarkMap map = to_message(pipeline->map(), "map", frame.stamp);
  std::printf("%zu landmark, at (%.1f, %.1f) m; a fiducial has %zu rows\n", map.landmarks.size(),
              map.landmarks.at(0).position.x, map.landmarks.at(0).position.y,
              fiducial_pattern("4X4_50", 0).size());
}
