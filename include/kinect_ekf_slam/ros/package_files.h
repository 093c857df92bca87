#pragma once

#include <string>

namespace kinect_ekf_slam {

/// The path of one of the package's own files, for example "config/worlds/room.yaml", whatever the working
/// directory: beside the running program, in the build's devel space as where it is installed.
std::string package_file(const std::string& name);

}  // namespace kinect_ekf_slam
