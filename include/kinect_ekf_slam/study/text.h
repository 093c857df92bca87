#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace kinect_ekf_slam {

/// printf into a string; what a study prints is short.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  char line[256];
  std::snprintf(line, sizeof(line), pattern, values...);
  return line;
}

/// A number in JSON, which knows none that are not finite.
inline std::string number(double value) { return std::isfinite(value) ? format("%.6g", value) : "null"; }

inline std::string json(double value) { return number(value); }

template <class Value>
std::string json(const std::vector<Value>& values) {
  std::string text = "[";
  for (const Value& value : values) text += (text.size() > 1 ? ", " : "") + json(value);
  return text + "]";
}

}  // namespace kinect_ekf_slam
