#include "kinect_ekf_slam/core/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "kinect_ekf_slam/core/descriptor.h"

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

bool write_all(int descriptor, const std::string& text) {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  if (::fchmod(descriptor, 0666 & ~mask) != 0) return false;
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    written += static_cast<std::size_t>(count);
  }
  return ::fsync(descriptor) == 0;
}

/// Takes away what was begun, and tells errno of before. Throws.
[[noreturn]] void give_up(const char* name, const std::string& path) {
  const int reason = errno;
  ::unlink(name);
  errno = reason;
  fail(path, "cannot be written");
}

/// Gives a complete file a name, and lets it take the place of `path`. A program that is killed between the
/// two leaves the name, with the whole file, to the next one that writes. False: another program has taken
/// the name away, which writes the same file now. Throws.
bool put_in_place(int nameless, const std::string& path) {
  const std::string name = path + ".new";
  const std::string open_file = "/proc/self/fd/" + std::to_string(nameless);
  ::unlink(name.c_str());
  if (::linkat(AT_FDCWD, open_file.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) != 0) {
    if (errno == EEXIST) return false;
    fail(path, "cannot be written");
  }
  if (std::rename(name.c_str(), path.c_str()) == 0) return true;
  if (errno == ENOENT) return false;
  give_up(name.c_str(), path);
}

}  // namespace

void write_file_atomically(const std::string& path, const std::string& text) {
  constexpr int kTries = 100;  // against another program
  for (int i = 0; i < kTries; ++i) {
    const Descriptor nameless(open_nameless(path));
    if (!nameless.is_open()) break;
    if (!write_all(nameless.number(), text)) fail(path, "cannot be written");
    if (put_in_place(nameless.number(), path)) return;
  }
  std::vector<char> name;
  const Descriptor temporary(open_temporary(path, &name));
  if (!write_all(temporary.number(), text) || std::rename(name.data(), path.c_str()) != 0) {
    give_up(name.data(), path);
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
