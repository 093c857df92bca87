#pragma once

namespace kinect_ekf_slam::names {

// Inputs besides those that sync/* name; relative, to be remapped as needed.
constexpr const char* kInitialPose = "initialpose";

// Outputs and services, in the node's private namespace.
constexpr const char* kPose = "pose";
constexpr const char* kOdometry = "odometry";
constexpr const char* kPath = "path";
constexpr const char* kMap = "map";
constexpr const char* kMarkers = "markers";
constexpr const char* kAssociations = "associations";
constexpr const char* kGlobalMap = "global_map";
constexpr const char* kGlobalMarkers = "global_markers";
constexpr const char* kSaveMap = "save_map";
constexpr const char* kLoadMap = "load_map";
constexpr const char* kReset = "reset";
constexpr const char* kPause = "pause";
constexpr const char* kSetMode = "set_mode";
constexpr const char* kRelocalize = "relocalize";
constexpr const char* kLive = "live";  ///< dynamic_reconfigure

}  // namespace kinect_ekf_slam::names
