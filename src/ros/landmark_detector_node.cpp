#include "kinect_ekf_slam/ros/landmark_detector_node.h"

#include <cv_bridge/cv_bridge.h>
#include <tf2/exceptions.h>

#include <cmath>
#include <stdexcept>

#include "kinect_ekf_slam/perception/debug_picture.h"
#include "kinect_ekf_slam/ros/conversions.h"
#include "kinect_ekf_slam/ros/detector_messages.h"
#include "kinect_ekf_slam/ros/names.h"
#include "kinect_ekf_slam/ros/picture_messages.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kLogPeriod = 5.0;  // s between repeated warnings

/// Calls `pair(option, live value)` for every parameter that both know.
template <class Options, class Config, class Pair>
void for_each_live(Options& options, Config& config, const Pair& pair) {
  pair(options.kinect_cylinder.max_depth, config.kinect_cylinder_max_depth);
  pair(options.kinect_cylinder.min_height, config.kinect_cylinder_min_height);
  pair(options.kinect_cylinder.max_height, config.kinect_cylinder_max_height);
  pair(options.kinect_cylinder.max_misfit, config.kinect_cylinder_max_misfit);
  pair(options.kinect_cylinder.max_taper, config.kinect_cylinder_max_taper);
  pair(options.laser_cylinder.range_sigma, config.laser_cylinder_range_sigma);
  pair(options.laser_cylinder.max_misfit, config.laser_cylinder_max_misfit);
  pair(options.fiducial.corner_sigma, config.aruco_corner_sigma);
  pair(options.features.matching.ratio, config.features_ratio);
  pair(options.features.matching.epipolar_error, config.features_epipolar_error);
  pair(options.features.two_views.reprojection_error, config.features_reprojection_error);
  pair(options.features.two_views.pixel_sigma, config.features_pixel_sigma);
}

}  // namespace

LandmarkDetectorNode::LandmarkDetectorNode(const ros::NodeHandle& handle,
                                           const ros::NodeHandle& private_handle,
                                           const tf2_ros::Buffer* transforms, const DetectorOptions& options)
    : handle_(handle),
      private_handle_(private_handle),
      transport_(private_handle),
      transforms_(transforms),
      options_(options),
      live_(live_mutex_, ros::NodeHandle(private_handle, names::kLive)),
      diagnostics_(handle, private_handle) {
  landmarks_ = handle_.advertise<LandmarkDetectionArray>("landmarks", 10);
  debug_ = transport_.advertise("debug", 1);
  if (options.type == DetectorType::kLaserCylinder) {
    scans_ = handle_.subscribe(options.scan_topic, static_cast<std::uint32_t>(options.queue_size),
                               &LandmarkDetectorNode::on_scan, this);
  } else {
    pictures_.emplace(options);
    connect_pictures();
  }
  DetectorConfig config = DetectorConfig::__getDefault__();
  for_each_live(options_, config, [](const auto& option, auto& live) { live = option; });
  live_.updateConfig(config);
  live_.setCallback([this](DetectorConfig& changed, std::uint32_t) { on_live_change(changed); });
  diagnostics_.setHardwareID("none");
  diagnostics_.add("detector", this, &LandmarkDetectorNode::report);
  diagnostics_timer_ =
      private_handle_.createWallTimer(ros::WallDuration(diagnostics_.getPeriod()),
                                      [this](const ros::WallTimerEvent&) { diagnostics_.force_update(); });
}

void LandmarkDetectorNode::connect_pictures() {
  const auto queue = static_cast<std::uint32_t>(options_.queue_size);
  const ros::Duration interval(options_.max_interval);
  image_transport::ImageTransport transport(handle_);
  colours_.subscribe(transport, options_.colour_topic, queue);
  infos_.subscribe(handle_, options_.info_topic, queue);
  if (options_.type == DetectorType::kAruco) {
    colour_synchronizer_ =
        std::make_unique<message_filters::Synchronizer<ColourPolicy>>(ColourPolicy(queue), colours_, infos_);
    colour_synchronizer_->setMaxIntervalDuration(interval);
    colour_synchronizer_->registerCallback(&LandmarkDetectorNode::on_colour_picture, this);
  } else if (options_.depth_source == DepthSource::kDisparity) {
    disparities_.subscribe(handle_, options_.disparity_topic, queue);
    stereo_synchronizer_ = std::make_unique<message_filters::Synchronizer<StereoPolicy>>(
        StereoPolicy(queue), colours_, disparities_, infos_);
    stereo_synchronizer_->setMaxIntervalDuration(interval);
    stereo_synchronizer_->registerCallback(&LandmarkDetectorNode::on_stereo_picture, this);
  } else {
    depths_.subscribe(transport, options_.depth_topic, queue);
    synchronizer_ =
        std::make_unique<message_filters::Synchronizer<Policy>>(Policy(queue), colours_, depths_, infos_);
    synchronizer_->setMaxIntervalDuration(interval);
    synchronizer_->registerCallback(&LandmarkDetectorNode::on_depth_picture, this);
  }
}

template <class Detect>
void LandmarkDetectorNode::process(const std_msgs::Header& header, const Detect& detect) {
  try {
    const Findings findings = detect();
    ++used_;
    found_ += findings.found.size();
    landmarks_.publish(to_message(findings, header));
  } catch (const std::exception& error) {  // ours, and those of OpenCV, cv_bridge and image_geometry
    ++unusable_;
    last_problem_ = error.what();
    last_problem_ = last_problem_.substr(0, last_problem_.find('\n'));
    ROS_WARN_THROTTLE(kLogPeriod, "%lu inputs could not be used so far; the last one: %s", unusable_,
                      last_problem_.c_str());
  }
}

Findings LandmarkDetectorNode::look_at(const std_msgs::Header& header, const RgbdPicture& picture) {
  Findings findings = pictures_->detect(picture, up_in(header));
  publish_debug(header, picture.colour, findings);
  return findings;
}

void LandmarkDetectorNode::on_depth_picture(const sensor_msgs::ImageConstPtr& colour,
                                            const sensor_msgs::ImageConstPtr& depth,
                                            const sensor_msgs::CameraInfoConstPtr& info) {
  process(colour->header, [&] { return look_at(colour->header, to_picture(colour, depth, *info)); });
}

void LandmarkDetectorNode::on_stereo_picture(const sensor_msgs::ImageConstPtr& colour,
                                             const stereo_msgs::DisparityImageConstPtr& disparity,
                                             const sensor_msgs::CameraInfoConstPtr& info) {
  process(colour->header, [&] { return look_at(colour->header, to_picture(colour, *disparity, *info)); });
}

void LandmarkDetectorNode::on_colour_picture(const sensor_msgs::ImageConstPtr& colour,
                                             const sensor_msgs::CameraInfoConstPtr& info) {
  process(colour->header, [&] { return look_at(colour->header, to_picture(colour, *info)); });
}

void LandmarkDetectorNode::on_scan(const sensor_msgs::LaserScanConstPtr& scan) {
  process(scan->header, [&] { return find_cylinders(to_scan(*scan), options_.laser_cylinder); });
}

void LandmarkDetectorNode::publish_debug(const std_msgs::Header& header, const cv::Mat& colour,
                                         const Findings& findings) {
  if (debug_.getNumSubscribers() == 0) return;
  const cv::Mat drawn = draw_findings(colour, findings);
  debug_.publish(cv_bridge::CvImage(header, sensor_msgs::image_encodings::BGR8, drawn).toImageMsg());
}

std::optional<Eigen::Vector3d> LandmarkDetectorNode::up_in(const std_msgs::Header& header) const {
  if (options_.level_frame.empty()) return std::nullopt;
  try {
    const auto transform = transforms_->lookupTransform(header.frame_id, options_.level_frame, header.stamp);
    return to_eigen(transform.transform).linear() * Eigen::Vector3d::UnitZ();
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

void LandmarkDetectorNode::on_live_change(const DetectorConfig& config) {
  bool is_finite = true;
  for_each_live(options_, config,
                [&](const auto&, const auto& live) { is_finite = is_finite && std::isfinite(live); });
  if (!is_finite) {
    ROS_WARN("A change of the detector's parameters is not a number and was not taken.");
    return;
  }
  if (config.kinect_cylinder_min_height >= config.kinect_cylinder_max_height ||
      config.kinect_cylinder_max_depth <= options_.kinect_cylinder.min_depth) {
    ROS_WARN("A change of the detector's parameters leaves no heights or no depths and was not taken.");
    return;
  }
  for_each_live(options_, config, [](auto& option, const auto& live) { option = live; });
  if (pictures_) pictures_->set_options(options_);
}

void LandmarkDetectorNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Status = diagnostic_msgs::DiagnosticStatus;
  if (used_ + unusable_ == 0) {
    status.summary(Status::WARN, "no input yet");
  } else if (unusable_ > 0) {
    status.summary(Status::WARN, "some inputs could not be used");
  } else {
    status.summary(Status::OK, "detecting");
  }
  status.add("inputs used", used_);
  status.add("inputs not usable", unusable_);
  status.add("last problem", last_problem_);
  status.add("landmarks found", found_);
}

}  // namespace kinect_ekf_slam
