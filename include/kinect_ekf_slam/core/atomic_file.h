#pragma once

#include <string>

namespace kinect_ekf_slam {

/// Writes a file so that at any moment, power cuts included, its name stands for the old text or the new one,
/// never for a part. Throws std::runtime_error, naming the file and what was wrong.
void write_file_atomically(const std::string& path, const std::string& text);

/// For before long work: throws as `write_file_atomically` would when `path` is no place to write to.
void require_writable(const std::string& path);

}  // namespace kinect_ekf_slam
