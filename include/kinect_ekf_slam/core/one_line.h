#pragma once

#include <cstddef>
#include <string>

namespace kinect_ekf_slam {

/// Text that came from elsewhere as a message of ours shows it: control characters are `?`, and of more than
/// `longest` bytes there is the beginning and `...`.
std::string one_line(std::string text, std::size_t longest = 300);

}  // namespace kinect_ekf_slam
