#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <kinect_ekf_slam/BeaconRanges.h>
#include <kinect_ekf_slam/LandmarkDetectionArray.h>
#include <message_filters/pass_through.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/synchronizer.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "kinect_ekf_slam/core/local_tangent_plane.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"
#include "kinect_ekf_slam/ros/position_messages.h"
#include "kinect_ekf_slam/ros/run_options.h"

namespace kinect_ekf_slam {

/// Messages in, sensor frames out: checks, converts, resolves frames at the message's own stamp, and lets
/// detections through that message_filters' ApproximateTime policy finds odometry (and IMU) for.
///
/// What is refused is counted by input and reason; it never reaches the estimate.
class SensorBridge {
 public:
  /// Where `source` is in `target` at a time, or nothing when tf does not know.
  using TransformLookup = std::function<std::optional<Eigen::Isometry3d>(
      const std::string& target, const std::string& source, const ros::Time& stamp)>;
  struct Handlers {
    std::function<void(SensorFrame)> on_frame;
    /// Time went back: the bridge has forgotten all it knew, whoever listens should too.
    std::function<void()> on_time_jump;
    /// One line about a message that was refused; the caller throttles.
    std::function<void(const std::string&)> on_refusal;
  };

  SensorBridge(const FrameOptions& frames, const SyncOptions& sync, TransformLookup lookup, Handlers handlers,
               const FusionOptions& fusion = {});

  /// True when the message was taken. `now` is the time of the run's clock; zero: it has none yet.
  bool add_odometry(const nav_msgs::Odometry::ConstPtr& message, const ros::Time& now);
  bool add_imu(const sensor_msgs::Imu::ConstPtr& message, const ros::Time& now);
  bool add_landmarks(const LandmarkDetectionArray::ConstPtr& message, const ros::Time& now);
  bool add_position(const geometry_msgs::PoseWithCovarianceStamped& message, const ros::Time& now);
  bool add_fix(const sensor_msgs::NavSatFix& message, const ros::Time& now);
  bool add_ranges(const BeaconRanges& message, const ros::Time& now);

  /// Where a person says that the robot is; its stamp is of no account. Nothing, and counted: not usable.
  std::optional<Pose3d> initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message);

  /// Forgets stamps and half-formed triples; the counters stay.
  void reset();

  /// "input: reason" -> how many messages were refused for it.
  const std::map<std::string, std::uint64_t>& refusals() const { return refusals_; }
  /// "input" -> how many messages were taken.
  const std::map<std::string, std::uint64_t>& accepted() const { return accepted_; }

 private:
  using Pairs = message_filters::sync_policies::ApproximateTime<nav_msgs::Odometry, LandmarkDetectionArray>;
  using Triples = message_filters::sync_policies::ApproximateTime<nav_msgs::Odometry, LandmarkDetectionArray,
                                                                  sensor_msgs::Imu>;
  struct Input {
    std::string name;
    TimeNs last_stamp = 0;
    int stamps_before_last = 0;  ///< in a row, by more than the time jump
    TimeNs leap = 0;             ///< a stamp far ahead of the last one that a second message must confirm
  };

  /// False, and counted, when the header says that the message cannot be used.
  bool check_stamp(Input& input, const std_msgs::Header& header, const ros::Time& now);
  /// False for a single stamp far ahead of the others: a bad one must not make all that follow look old.
  bool confirm_leap(Input& input, TimeNs stamp) const;
  /// A message that waits for nothing: checked, and where its sensor is. Nothing, and counted: not usable.
  std::optional<Eigen::Isometry3d> admit(Input& input, const std_msgs::Header& header,
                                         const std::string& sensor,
                                         const std::optional<MessageProblem>& problem, const ros::Time& now);
  bool refuse(const Input& input, const std::string& reason, const std::string& detail);
  void take(Input& input, TimeNs stamp);
  std::optional<Eigen::Isometry3d> base_from(const std::string& frame_id, const ros::Time& stamp) const;
  /// Both are fed all the time, so that what waits is not lost when the IMU comes or goes.
  void make_synchronizers();
  void on_pair(const LandmarkDetectionArray::ConstPtr& message);    ///< counts while there is no IMU
  void on_triple(const LandmarkDetectionArray::ConstPtr& message);  ///< counts while there is one
  void on_synchronized(const LandmarkDetectionArray::ConstPtr& message);

  FrameOptions frames_;
  SyncOptions sync_;
  FusionOptions fusion_;
  std::optional<LocalTangentPlane> plane_;  ///< of fusion/frame, once its datum is known
  bool datum_is_sure_ = false;              ///< given, or a second fix is near it; until then no fix is used
  TransformLookup lookup_;
  Handlers handlers_;

  bool imu_expected_ = false;
  Input odometry_input_{"odometry"};
  Input imu_input_{"imu"};
  Input landmarks_input_{"landmarks"};
  Input position_input_{"global_position"};
  Input fix_input_{"fix"};
  Input ranges_input_{"beacon_ranges"};
  Input initial_pose_input_{"initialpose"};
  std::map<std::string, std::uint64_t> refusals_;
  std::map<std::string, std::uint64_t> accepted_;
  std::deque<TimeNs> unsynchronized_;  ///< stamps of detections that wait for their odometry

  message_filters::PassThrough<nav_msgs::Odometry> odometry_filter_;
  message_filters::PassThrough<sensor_msgs::Imu> imu_filter_;
  message_filters::PassThrough<LandmarkDetectionArray> landmarks_filter_;
  std::unique_ptr<message_filters::Synchronizer<Pairs>> pairs_;
  std::unique_ptr<message_filters::Synchronizer<Triples>> triples_;
};

}  // namespace kinect_ekf_slam
