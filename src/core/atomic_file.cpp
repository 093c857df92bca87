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

/// A new file in the folder of `path`, so that a rename stays within one file system. Throws.
int open_temporary(const std::string& path, std::vector<char>* name) {
  const std::string pattern = path + ".XXXXXX";
  name->assign(pattern.begin(), pattern.end());
  name->push_back('\0');
  const int descriptor = ::mkstemp(name->data());
  if (descriptor < 0) fail(path, "cannot be created");
  return descriptor;
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
  std::vector<char> temporary;
  const int descriptor = open_temporary(path, &temporary);
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

void require_writable(const std::string& path) {
  if (path.empty()) throw std::runtime_error("an empty name is given for a file to write");
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) {
    errno = EISDIR;
    fail(path, "cannot be written");
  }
  std::vector<char> temporary;
  ::close(open_temporary(path, &temporary));
  ::unlink(temporary.data());
}

}  // namespace kinect_ekf_slam
