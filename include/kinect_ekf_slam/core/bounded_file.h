#pragma once

#include <cstddef>
#include <string>

namespace kinect_ekf_slam {

/// The bytes of a regular file. It is looked at after it is opened, so that nothing can be put in its place
/// between the look and the reading; a link is not followed, and a pipe or a device is not waited for.
/// Throws std::runtime_error: `path: what is wrong`, also for a file of more than `most` bytes.
std::string read_regular_file(const std::string& path, std::size_t most);

}  // namespace kinect_ekf_slam
