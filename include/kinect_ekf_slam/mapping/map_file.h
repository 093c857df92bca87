#pragma once

#include <stdexcept>
#include <string>

#include "kinect_ekf_slam/mapping/saved_state.h"

namespace kinect_ekf_slam {

/// One line that names the file and what is wrong with it.
class MapFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The only folder that maps are read from and written to.
class MapDirectory {
 public:
  /// A leading `~` stands for the home folder.
  explicit MapDirectory(const std::string& directory);

  /// The path of a map in the folder. Throws MapFileError unless `file_name` is a plain name that ends in
  /// `.yaml`, and unless what has that name, if anything does, is a regular file: no link leads out.
  std::string resolve(const std::string& file_name) const;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Writes a map: version, frame, time, the parameters it was made with (YAML text, may be empty), landmarks,
/// and the full covariance. Atomic. Creates the folder. Throws MapFileError.
void write_map(const std::string& path, const std::string& frame, const SavedState& state,
               const std::string& parameters);

/// Reads a map that write_map wrote. Throws MapFileError for a file that is absent, damaged, of another kind,
/// newer than this version, in another frame than `expected_frame`, or whose covariance is none.
SavedState read_map(const std::string& path, const std::string& expected_frame);

}  // namespace kinect_ekf_slam
