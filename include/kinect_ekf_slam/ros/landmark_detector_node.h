#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <dynamic_reconfigure/server.h>
#include <image_transport/subscriber_filter.h>
#include <kinect_ekf_slam/DetectorConfig.h>
#include <message_filters/subscriber.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/synchronizer.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/LaserScan.h>
#include <stereo_msgs/DisparityImage.h>
#include <tf2_ros/buffer.h>

#include <boost/thread/recursive_mutex.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/ros/detector_options.h"
#include "kinect_ekf_slam/ros/picture_detector.h"

namespace kinect_ekf_slam {

/// Turns pictures or scans into `landmarks`. What it cannot use it counts, and says so in one line.
class LandmarkDetectorNode {
 public:
  /// Throws what PictureDetector does.
  LandmarkDetectorNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                       const tf2_ros::Buffer* transforms, const DetectorOptions& options);

 private:
  using Policy = message_filters::sync_policies::ApproximateTime<sensor_msgs::Image, sensor_msgs::Image,
                                                                 sensor_msgs::CameraInfo>;
  using StereoPolicy =
      message_filters::sync_policies::ApproximateTime<sensor_msgs::Image, stereo_msgs::DisparityImage,
                                                      sensor_msgs::CameraInfo>;
  using ColourPolicy =
      message_filters::sync_policies::ApproximateTime<sensor_msgs::Image, sensor_msgs::CameraInfo>;

  void connect_pictures();
  void on_depth_picture(const sensor_msgs::ImageConstPtr& colour, const sensor_msgs::ImageConstPtr& depth,
                        const sensor_msgs::CameraInfoConstPtr& info);
  void on_stereo_picture(const sensor_msgs::ImageConstPtr& colour,
                         const stereo_msgs::DisparityImageConstPtr& disparity,
                         const sensor_msgs::CameraInfoConstPtr& info);
  void on_colour_picture(const sensor_msgs::ImageConstPtr& colour,
                         const sensor_msgs::CameraInfoConstPtr& info);
  void on_scan(const sensor_msgs::LaserScanConstPtr& scan);
  void on_live_change(const DetectorConfig& config);

  /// Runs `detect`, publishes what it finds; counts what it throws.
  template <class Detect>
  void process(const std_msgs::Header& header, const Detect& detect);
  Findings look_at(const std_msgs::Header& header, const RgbdPicture& picture);
  void publish_debug(const std_msgs::Header& header, const cv::Mat& colour, const Findings& findings);
  /// Where up is in the picture's frame, where tf knows it.
  std::optional<Eigen::Vector3d> up_in(const std_msgs::Header& header) const;
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  image_transport::ImageTransport transport_;
  const tf2_ros::Buffer* transforms_;
  DetectorOptions options_;
  std::optional<PictureDetector> pictures_;

  ros::Publisher landmarks_;
  image_transport::Publisher debug_;
  ros::Subscriber scans_;
  image_transport::SubscriberFilter colours_;
  image_transport::SubscriberFilter depths_;
  message_filters::Subscriber<stereo_msgs::DisparityImage> disparities_;
  message_filters::Subscriber<sensor_msgs::CameraInfo> infos_;
  std::unique_ptr<message_filters::Synchronizer<Policy>> synchronizer_;
  std::unique_ptr<message_filters::Synchronizer<StereoPolicy>> stereo_synchronizer_;
  std::unique_ptr<message_filters::Synchronizer<ColourPolicy>> colour_synchronizer_;
  boost::recursive_mutex live_mutex_;
  dynamic_reconfigure::Server<DetectorConfig> live_;
  diagnostic_updater::Updater diagnostics_;
  ros::WallTimer diagnostics_timer_;

  std::uint64_t used_ = 0;
  std::uint64_t unusable_ = 0;
  std::uint64_t found_ = 0;
  std::string last_problem_;
};

}  // namespace kinect_ekf_slam
