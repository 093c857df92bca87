#include "kinect_ekf_slam/ros/command_line.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace kinect_ekf_slam {

bool CommandLine::next() {
  if (position_ == words_.size()) return false;
  ++position_;
  if (word() == "--help" || word() == "-h") {
    std::fputs(usage_.c_str(), stdout);
    std::exit(0);
  }
  return true;
}

std::string CommandLine::value() {
  if (position_ == words_.size()) fail_at_word("a value must follow");
  return words_[position_++];
}

std::vector<std::string> CommandLine::assignments() {
  std::vector<std::string> assignments{value()};
  while (position_ < words_.size() && words_[position_].front() != '-' &&
         words_[position_].find('=') != std::string::npos) {
    assignments.push_back(value());
  }
  return assignments;
}

void CommandLine::fail(const std::string& line) const {
  std::fprintf(stderr, "%s: %s\n", program_.c_str(), line.c_str());
  std::exit(2);
}

std::function<void(double)> progress_bar() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [](double share) {
    const int filled = static_cast<int>(share * 40.0);
    std::fprintf(stderr, "\r[%-40s] %3.0f %%", std::string(filled, '#').c_str(), 100.0 * share);
  };
}

void clear_progress_bar() {
  if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r%60s\r", "");
}

}  // namespace kinect_ekf_slam
