#include "kinect_ekf_slam/core/atomic_file.h"

#include <fcntl.h>
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

/// A new file in that folder that has no name yet: nothing of it stays when the program is killed. Negative
/// on file systems that have no such files.
int open_nameless(const std::string& path) {
  const auto slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  return ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
}

/// Names it, beside `path`. False, and errno says why: it cannot be.
bool give_name(int descriptor, const std::string& path, std::vector<char>* name) {
  const std::string text = path + "." + std::to_string(::getpid());
  name->assign(text.c_str(), text.c_str() + text.size() + 1);
  ::unlink(name->data());  // of a program that was killed and had the same number
  const std::string open_file = "/proc/self/fd/" + std::to_string(descriptor);
  return ::linkat(AT_FDCWD, open_file.c_str(), AT_FDCWD, name->data(), AT_SYMLINK_FOLLOW) == 0;
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
  const mode_t mask = ::umask(0);
  ::umask(mask);
  std::vector<char> name;
  int descriptor = open_nameless(path);
  const bool is_nameless = descriptor >= 0;
  if (!is_nameless) descriptor = open_temporary(path, &name);
  bool complete = ::fchmod(descriptor, 0666 & ~mask) == 0 && write_all(descriptor, text);
  if (complete && is_nameless) complete = give_name(descriptor, path, &name);
  const int error = errno;
  ::close(descriptor);
  if (!complete || std::rename(name.data(), path.c_str()) != 0) {
    const int reason = complete ? errno : error;
    if (!name.empty()) ::unlink(name.data());
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
