#include "kinect_ekf_slam/core/atomic_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace kinect_ekf_slam {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
  throw std::runtime_error(path + ": " + what + ": " + std::strerror(errno));
}

bool write_all(int descriptor, const std::string& text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    written += static_cast<std::size_t>(count);
  }
  return ::fsync(descriptor) == 0;
}

}  // namespace

void write_file_atomically(const std::string& path, const std::string& text) {
  const std::string pattern = path + ".XXXXXX";  // in the same folder: a rename within one file system
  std::vector<char> temporary(pattern.begin(), pattern.end());
  temporary.push_back('\0');
  const int descriptor = ::mkstemp(temporary.data());
  if (descriptor < 0) fail(path, "cannot be created");
  const mode_t mask = ::umask(0);
  ::umask(mask);
  const bool complete = ::fchmod(descriptor, 0666 & ~mask) == 0 && write_all(descriptor, text);
  const int error = errno;
  ::close(descriptor);
  if (!complete || std::rename(temporary.data(), path.c_str()) != 0) {
    if (!complete) errno = error;
    const int reason = errno;
    ::unlink(temporary.data());
    errno = reason;
    fail(path, "cannot be written");
  }
}

}  // namespace kinect_ekf_slam
