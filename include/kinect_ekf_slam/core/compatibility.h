#pragma once

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <system_error>
#include <type_traits>

/// What the supported platforms do not have alike, and nothing else: Debian 12 (g++ 12, OpenCV 4.6,
/// Eigen 3.4) and ROS Noetic on Ubuntu 20.04 (g++ 9, OpenCV 4.2, Eigen 3.3). docs/reuse.md lists the
/// differences.

/// OpenCV has had a SIFT of its own since 4.4. OpenCV's version header is needed where this is used.
#define KINECT_EKF_SLAM_HAS_SIFT (CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 4))

namespace kinect_ekf_slam {

/// For a standard library whose `charconv` knows whole numbers only: g++'s before 11. Its numbers have a
/// point in any country, as long as the program does not call setlocale, which none of ours does.
namespace without_charconv {

inline void append_number(std::string* text, double value, int digits) {
  char buffer[40];
  const int length = std::snprintf(buffer, sizeof(buffer), "%.*g", digits, value);
  text->append(buffer, static_cast<std::size_t>(length));
}

inline void append_number(std::string* text, double value) {
  constexpr int kAlwaysEnough = 17;
  std::string digits;
  for (int count = 1; count <= kAlwaysEnough; ++count) {
    digits.clear();
    append_number(&digits, value, count);
    if (std::strtod(digits.c_str(), nullptr) == value) break;
  }
  *text += digits;
}

inline bool read_number(const std::string& text, double* value) {
  if (text.find_first_of("+xX \t\n") == 0 || text.find_first_of("xX") != std::string::npos) return false;
  char* end = nullptr;
  errno = 0;
  *value = std::strtod(text.c_str(), &end);
  return !text.empty() && end == text.c_str() + text.size() && !(errno == ERANGE && std::abs(*value) > 1.0);
}

}  // namespace without_charconv

#if defined(__cpp_lib_to_chars)
/// Appends `value` with at most so many digits.
inline void append_number(std::string* text, double value, int digits) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::general, digits);
  text->append(buffer, end.ptr);
}

/// Appends the shortest text that reads back as `value`.
inline void append_number(std::string* text, double value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value);
  text->append(buffer, end.ptr);
}
#else
using without_charconv::append_number;
#endif

/// The number that the whole text is; false: it is none, or too large for its type.
template <class Number>
bool read_number(const std::string& text, Number* value) {
#if !defined(__cpp_lib_to_chars)
  if constexpr (std::is_floating_point_v<Number>)
    return without_charconv::read_number(text, value);
  else
#endif
  {
    const auto end = std::from_chars(text.data(), text.data() + text.size(), *value);
    return end.ec == std::errc() && end.ptr == text.data() + text.size();
  }
}

}  // namespace kinect_ekf_slam
