#include "kinect_ekf_slam/ros/slam_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/mapping/map_file.h"
#include "kinect_ekf_slam/ros/conversions.h"
#include "kinect_ekf_slam/ros/live_options.h"
#include "kinect_ekf_slam/ros/names.h"
#include "kinect_ekf_slam/ros/static_transforms.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kLogPeriod = 5.0;  // s between repeated warnings

constexpr std::size_t kMostFrames = 100;  // that are remembered as unknown

std::map<std::string, std::string> position_topics(const ros::NodeHandle& handle,
                                                   const FusionOptions& fusion) {
  std::map<std::string, std::string> topics;
  for (const auto& [input, topic] :
       {std::make_pair("global_position", fusion.positions_topic), std::make_pair("fix", fusion.fix_topic),
        std::make_pair("beacon_ranges", fusion.ranges_topic)}) {
    if (!topic.empty()) topics[input] = handle.resolveName(topic);
  }
  return topics;
}

const char* mode_name(Mode mode) { return mode == Mode::kSlam ? "slam" : "localization"; }

}  // namespace

SlamNode::SlamNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                   tf2_ros::Buffer* transforms, const RunOptions& options)
    : handle_(handle),
      private_handle_(private_handle),
      transforms_(transforms),
      options_(options),
      session_(options,
               [this](const std::string& target, const std::string& source, const ros::Time& stamp) {
                 return base_from(target, source, stamp);
               },
               {[this](const SensorFrame& frame, const SlamResult& result) { on_result(frame, result); },
                [this] {
                  ROS_WARN("Time went back: a new run starts.");
                  forget_run();
                },
                [](const std::string& line) { ROS_WARN_THROTTLE(kLogPeriod, "%s", line.c_str()); }}),
      health_({handle_.resolveName(options.sync.odometry_topic),
               options.sync.imu_topic.empty() ? "none" : handle_.resolveName(options.sync.imu_topic),
               handle_.resolveName(options.sync.landmarks_topic), position_topics(handle_, options.fusion),
               options.output.pose_sigma_warning, options.pipeline.space == SpaceType::kSpatial ? 3 : 2},
              ros::Time::now()),
      painter_(options.frames.map, options.output.marker_sigmas, options.pipeline.space),
      path_(options.output.path_step, static_cast<std::size_t>(options.output.path_length)),
      dead_reckoned_path_(options.output.path_step, static_cast<std::size_t>(options.output.path_length)),
      correction_(options.output.correction_time),
      diagnostics_(handle_, private_handle_) {
  if (options_.map.load_at_start) {
    ROS_INFO("map loaded from %s", load("", false).c_str());
  } else if (options_.pipeline.mode == Mode::kLocalization) {
    throw std::runtime_error("mode: localization needs a map: set map/load_at_start and map/file_name");
  }
  add_static_transforms(options_.frames.static_transforms, ros::Time::now(), transforms_);
  connect();
}

void SlamNode::connect() {
  const SyncOptions& sync = options_.sync;
  const auto queue = static_cast<std::uint32_t>(sync.queue_size);
  pose_publisher_ = private_handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>(names::kPose, 10);
  odometry_publisher_ = private_handle_.advertise<nav_msgs::Odometry>(names::kOdometry, 10);
  path_publisher_ = private_handle_.advertise<nav_msgs::Path>(names::kPath, 1);
  map_publisher_ = private_handle_.advertise<LandmarkMap>(names::kMap, 1, true);
  // Markers are drawn for those who look at them, and at once for who comes: the timer stands still when the
  // clock does.
  const auto show = [this](const ros::SingleSubscriberPublisher& /*subscriber*/) {
    scene_changed_ = true;
    publish_scene();
  };
  marker_publisher_ =
      private_handle_.advertise<visualization_msgs::MarkerArray>(names::kMarkers, 1, show, {}, {}, true);
  association_publisher_ = private_handle_.advertise<AssociationArray>(names::kAssociations, 10);
  services_ = {private_handle_.advertiseService(names::kSaveMap, &SlamNode::save_map, this),
               private_handle_.advertiseService(names::kLoadMap, &SlamNode::load_map, this),
               private_handle_.advertiseService(names::kReset, &SlamNode::reset, this),
               private_handle_.advertiseService(names::kPause, &SlamNode::pause, this),
               private_handle_.advertiseService(names::kSetMode, &SlamNode::set_mode, this),
               private_handle_.advertiseService(names::kRelocalize, &SlamNode::relocalize, this)};
  const auto at_once = ros::TransportHints().tcpNoDelay();
  subscribers_ = {handle_.subscribe(sync.odometry_topic, queue, &SlamNode::on_odometry, this, at_once),
                  handle_.subscribe(sync.landmarks_topic, queue, &SlamNode::on_landmarks, this, at_once),
                  handle_.subscribe(names::kInitialPose, 1, &SlamNode::on_initial_pose, this)};
  if (!sync.imu_topic.empty())
    subscribers_.push_back(handle_.subscribe(sync.imu_topic, queue, &SlamNode::on_imu, this, at_once));
  const FusionOptions& fusion = options_.fusion;
  if (!fusion.positions_topic.empty())
    subscribers_.push_back(handle_.subscribe(fusion.positions_topic, queue, &SlamNode::on_position, this));
  if (!fusion.fix_topic.empty())
    subscribers_.push_back(handle_.subscribe(fusion.fix_topic, queue, &SlamNode::on_fix, this));
  if (!fusion.ranges_topic.empty())
    subscribers_.push_back(handle_.subscribe(fusion.ranges_topic, queue, &SlamNode::on_ranges, this));

  live_ = std::make_unique<dynamic_reconfigure::Server<SlamConfig>>(
      live_mutex_, ros::NodeHandle(private_handle_, names::kLive));
  live_->updateConfig(to_live_config(options_));
  live_->setCallback([this](SlamConfig& config, std::uint32_t) { on_live_change(&config); });

  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", [this](diagnostic_updater::DiagnosticStatusWrapper& status) {
    health_.report_inputs(session_.input(), ros::Time::now(), status);
  });
  diagnostics_.add("estimate", [this](diagnostic_updater::DiagnosticStatusWrapper& status) {
    health_.report_estimate(status);
  });
  if (options_.global_map.enabled) {
    global_map_ = std::make_unique<GlobalMapPublisher>(private_handle_, options_);
    diagnostics_.add("global map", [this](diagnostic_updater::DiagnosticStatusWrapper& status) {
      global_map_->report(status);
    });
  }
  health_.set_state(mode_name(options_.pipeline.mode), paused_);
  // Wall time: a simulated clock that stands still is worth a report as well.
  diagnostics_timer_ =
      private_handle_.createWallTimer(ros::WallDuration(diagnostics_.getPeriod()),
                                      [this](const ros::WallTimerEvent&) { diagnostics_.force_update(); });
  scene_timer_ = private_handle_.createTimer(ros::Duration(1.0 / options_.output.marker_rate),
                                             [this](const ros::TimerEvent&) { publish_scene(); });
  if (options_.map.autosave_period > 0.0) {  // wall time: a power cut keeps to no simulated clock
    autosave_timer_ = private_handle_.createWallTimer(ros::WallDuration(options_.map.autosave_period),
                                                      [this](const ros::WallTimerEvent&) { autosave(); });
  }
  publish_scene();
}

ros::Time SlamNode::now() {
  const ros::Time now = ros::Time::now();
  if (!last_now_.isZero() && seconds_between(now, last_now_) > options_.sync.time_jump) {
    ROS_WARN("The clock went back by %.1f s: a new run starts.", seconds_between(now, last_now_));
    session_.reset();
    forget_run();
  }
  last_now_ = now;
  return now;
}

std::optional<Eigen::Isometry3d> SlamNode::base_from(const std::string& target, const std::string& source,
                                                     const ros::Time& stamp) {
  // A transform that comes late is waited for, but a missing one must not stop the node at each message.
  constexpr double kPatience = 1.0;  // s between waits for a frame that is not there
  const auto unknown = unknown_since_.find(source);
  if (unknown == unknown_since_.end() || (ros::WallTime::now() - unknown->second).toSec() > kPatience) {
    // Wall time: a simulated clock may stand still.
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(options_.frames.tf_timeout);
    while (!transforms_->canTransform(target, source, stamp) && ros::WallTime::now() < end) {
      ros::WallDuration(0.002).sleep();
    }
    unknown_since_[source] = ros::WallTime::now();
    if (unknown_since_.size() > kMostFrames) unknown_since_.clear();
  }
  auto transform = lookup_transform(*transforms_, target, source, stamp);
  if (transform) unknown_since_.erase(source);
  return transform;
}

void SlamNode::on_odometry(const Event<nav_msgs::Odometry>& event) {
  const ros::Time time = now();
  if (!session_.input().add_odometry(event.getConstMessage(), time)) return;
  health_.note_input("odometry", time, event.getReceiptTime());
  publish_pose(*event.getConstMessage());
}

void SlamNode::on_imu(const Event<sensor_msgs::Imu>& event) {
  const ros::Time time = now();
  if (session_.input().add_imu(event.getConstMessage(), time))
    health_.note_input("imu", time, event.getReceiptTime());
}

void SlamNode::on_landmarks(const Event<BoundedLandmarks>& event) {
  const ros::Time time = now();
  if (paused_) return;
  if (session_.input().add_landmarks(event.getConstMessage(), time))
    health_.note_input("landmarks", time, event.getReceiptTime());
}

void SlamNode::on_position(const Event<geometry_msgs::PoseWithCovarianceStamped>& event) {
  const ros::Time time = now();
  if (paused_) return;
  if (session_.input().add_position(*event.getConstMessage(), time))
    health_.note_input("global_position", time, event.getReceiptTime());
}

void SlamNode::on_fix(const Event<sensor_msgs::NavSatFix>& event) {
  const ros::Time time = now();
  if (paused_) return;
  if (session_.input().add_fix(*event.getConstMessage(), time))
    health_.note_input("fix", time, event.getReceiptTime());
}

void SlamNode::on_ranges(const Event<BeaconRanges>& event) {
  const ros::Time time = now();
  if (paused_) return;
  if (session_.input().add_ranges(*event.getConstMessage(), time))
    health_.note_input("beacon_ranges", time, event.getReceiptTime());
}

void SlamNode::on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped::ConstPtr& message) {
  const std::optional<Pose3d> pose = session_.input().initial_pose(*message);
  if (!pose) return;
  session_.set_pose(*pose);
  if (global_map_) global_map_->break_path();
  correction_.jump();
  scene_changed_ = true;
  ROS_INFO("initialpose: the robot is at (%.2f, %.2f) m", pose->map_from_base.translation().x(),
           pose->map_from_base.translation().y());
}

void SlamNode::on_result(const SensorFrame& frame, const SlamResult& result) {
  scene_changed_ = true;
  finite_ = result.finite;
  health_.note_result(result);
  if (!result.finite) return;
  if (global_map_) global_map_->add(frame);
  publish_alignment(result);
  dead_reckoned_path_.add(to_point(result.dead_reckoned.translation()));
  if (!result.looked) return;
  last_outcomes_ = result.outcomes;
  association_publisher_.publish(to_message(result.outcomes, options_.frames.map, frame.stamp));
}

void SlamNode::on_live_change(SlamConfig* config) {
  if (!is_finite(*config)) {
    ROS_WARN("dynamic_reconfigure: ignored, a value is not finite");
    *config = to_live_config(options_);  // or the next change would come with that value again
    return;
  }
  if (config->sensor_min_depth > config->sensor_max_depth) {
    ROS_WARN("dynamic_reconfigure: ignored, sensor_min_depth %g is more than sensor_max_depth %g",
             config->sensor_min_depth, config->sensor_max_depth);
    *config = to_live_config(options_);
    return;
  }
  apply_live_config(*config, &options_);
  session_.set_live_options(options_.pipeline);
  painter_.set_sigmas(options_.output.marker_sigmas);
  scene_changed_ = true;
}

void SlamNode::publish_pose(const nav_msgs::Odometry& odometry) {
  if (!finite_) return;
  const Pose3d pose = session_.pose_at(to_time(odometry.header.stamp));
  if (!pose.map_from_base.matrix().allFinite() || !pose.covariance.allFinite()) {
    finite_ = false;
    return;
  }
  health_.note_pose(pose);
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = options_.frames.map;
  message.header.stamp = odometry.header.stamp;
  message.pose = to_pose_with_covariance(pose);
  pose_publisher_.publish(message);

  nav_msgs::Odometry in_map = odometry;
  in_map.header = message.header;
  in_map.child_frame_id = options_.frames.base;
  in_map.pose = message.pose;
  odometry_publisher_.publish(in_map);

  if (path_.add(message.pose.pose.position)) {
    geometry_msgs::PoseStamped step;
    step.header = message.header;
    step.pose = message.pose.pose;
    path_message_.poses.push_back(step);
    if (path_message_.poses.size() > path_.points().size()) {
      path_message_.poses.erase(
          path_message_.poses.begin(),
          path_message_.poses.end() - static_cast<std::ptrdiff_t>(path_.points().size()));
    }
    scene_changed_ = true;
  }
  if (options_.output.publish_tf) publish_transform(pose, odometry.pose.pose);
}

void SlamNode::publish_transform(const Pose3d& pose, const geometry_msgs::Pose& odom_from_base) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = options_.frames.map;
  message.header.stamp = to_ros(pose.stamp) + ros::Duration(options_.output.transform_tolerance);
  // tf warns of repeated stamps; one that is much older is a new run's.
  const double back = seconds_between(message.header.stamp, last_transform_);
  if (back >= 0.0 && back <= options_.sync.time_jump) return;
  last_transform_ = message.header.stamp;
  message.child_frame_id = options_.frames.odom;
  message.transform =
      to_transform(correction_.follow(pose.map_from_base, to_eigen(odom_from_base), pose.stamp));
  broadcaster_.sendTransform(message);
}

void SlamNode::publish_alignment(const SlamResult& result) {
  const bool was_aligned = std::exchange(is_aligned_, result.map_from_global.has_value());
  if (!is_aligned_ || was_aligned || !options_.output.publish_tf) return;
  geometry_msgs::TransformStamped message;
  message.header.frame_id = options_.fusion.frame;
  message.header.stamp = to_ros(result.pose.stamp);
  message.child_frame_id = options_.frames.map;
  message.transform = to_transform(result.map_from_global->inverse());
  static_broadcaster_.sendTransform(message);
  ROS_INFO("global positions: the map lies in '%s' at (%.2f, %.2f) m, turned by %.1f deg",
           options_.fusion.frame.c_str(), message.transform.translation.x, message.transform.translation.y,
           degrees(2.0 * std::atan2(message.transform.rotation.z, message.transform.rotation.w)));
}

void SlamNode::publish_scene() {
  if (!scene_changed_ || !finite_) return;
  scene_changed_ = false;
  MarkerScene scene;
  scene.map = session_.pipeline().map();
  scene.beacons = session_.pipeline().beacons();
  scene.pose = session_.pose_at(session_.newest());
  health_.note_map(scene.map.size());
  map_publisher_.publish(to_message(scene.map, options_.frames.map, scene.pose.stamp));
  if (path_publisher_.getNumSubscribers() > 0) {
    path_message_.header.frame_id = options_.frames.map;
    path_message_.header.stamp = to_ros(scene.pose.stamp);
    path_publisher_.publish(path_message_);
  }
  if (marker_publisher_.getNumSubscribers() == 0) return;
  scene.outcomes = last_outcomes_;
  scene.path = path_.points();
  scene.dead_reckoned_path = dead_reckoned_path_.points();
  marker_publisher_.publish(painter_.paint(scene));
}

void SlamNode::forget_what_was_shown() {
  path_.clear();
  dead_reckoned_path_.clear();
  path_message_.poses.clear();
  last_outcomes_.clear();
  correction_.jump();
  finite_ = true;
  is_aligned_ = false;
  health_.reset_estimate();
  marker_publisher_.publish(painter_.clear());
  scene_changed_ = true;
}

void SlamNode::forget_run() {
  forget_what_was_shown();
  if (global_map_) global_map_->restart();
}

std::string SlamNode::path_of(const std::string& file_name) const {
  return MapDirectory(options_.map.directory).resolve(file_name.empty() ? options_.map.file_name : file_name);
}

std::string SlamNode::save(const std::string& file_name) {
  std::string path = path_of(file_name);
  write_map(path, options_.frames.map, session_.pipeline().save(), options_.text);
  return path;
}

std::string SlamNode::load(const std::string& file_name, bool keep_saved_pose) {
  const std::string path = path_of(file_name);
  session_.load(read_map(path, options_.frames.map), keep_saved_pose);
  return path + ": " + std::to_string(session_.pipeline().map().size()) + " landmarks";
}

bool SlamNode::save_map(SaveMap::Request& request, SaveMap::Response& response) {
  try {
    response.message = save(request.file_name);
    response.success = true;
  } catch (const MapFileError& error) {
    response.message = error.what();
  }
  return true;
}

bool SlamNode::load_map(LoadMap::Request& request, LoadMap::Response& response) {
  try {
    response.message = load(request.file_name, request.keep_saved_pose);
    response.success = true;
    forget_what_was_shown();
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

bool SlamNode::reset(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  session_.reset();
  forget_run();
  response.success = true;
  response.message = options_.pipeline.mode == Mode::kSlam
                         ? "pose and map are forgotten"
                         : "the pose is that of the parameters again; the map stays";
  return true;
}

bool SlamNode::pause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  paused_ = request.data;
  health_.set_state(mode_name(options_.pipeline.mode), paused_);
  response.success = true;
  response.message =
      paused_ ? "paused: detections, positions and ranges are not used, odometry still moves the pose"
              : "running";
  return true;
}

bool SlamNode::set_mode(SetMode::Request& request, SetMode::Response& response) {
  if (request.mode != "slam" && request.mode != "localization") {
    response.message = "mode: '" + request.mode + "' given, allowed: slam, localization";
    return true;
  }
  const Mode mode = request.mode == "slam" ? Mode::kSlam : Mode::kLocalization;
  if (mode == Mode::kLocalization && session_.pipeline().map().empty()) {
    response.message = "mode: localization needs a map: load one or drive first";
    return true;
  }
  session_.set_mode(mode);
  options_.pipeline.mode = mode;
  health_.set_state(request.mode, paused_);
  response.success = true;
  response.message = "mode is " + request.mode;
  return true;
}

bool SlamNode::relocalize(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  try {
    session_.relocalize();
    response.success = true;
    response.message = "searching: drive about; diagnostics say when the robot is found";
  } catch (const std::invalid_argument& error) {
    response.message = error.what();
  }
  return true;
}

std::string SlamNode::save_unless_empty() { return session_.pipeline().map().empty() ? "" : save(""); }

void SlamNode::autosave() {
  try {
    health_.note_autosave(save_unless_empty().empty() ? "nothing yet: no landmark is mapped" : "saved", true);
  } catch (const MapFileError& error) {
    health_.note_autosave(error.what(), false);
    ROS_WARN_THROTTLE(kLogPeriod, "map/autosave_period: the map is not saved: %s", error.what());
  }
}

void SlamNode::shut_down() {
  if (!options_.map.save_at_exit) return;
  try {
    const std::string path = save_unless_empty();
    if (path.empty()) {
      std::printf("slam_node: no landmark was mapped, nothing saved\n");
    } else {
      std::printf("slam_node: map saved to %s\n", path.c_str());
    }
  } catch (const MapFileError& error) {
    std::fprintf(stderr, "slam_node: map not saved: %s\n", error.what());
  }
}

}  // namespace kinect_ekf_slam
