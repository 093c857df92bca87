#include "kinect_ekf_slam/ros/package_files.h"

#include <filesystem>
#include <system_error>

namespace kinect_ekf_slam {

std::string package_file(const std::string& name) {
  std::error_code none;  // without /proc the path is relative to the working directory
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path prefix =
      program.parent_path().parent_path().parent_path();  // of lib/PACKAGE/program
  const std::filesystem::path file = prefix / "share" / "kinect_ekf_slam" / name;
  return std::filesystem::exists(file, none) ? file.string() : name;
}

}  // namespace kinect_ekf_slam
