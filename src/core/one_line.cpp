#include "kinect_ekf_slam/core/one_line.h"

#include <algorithm>

namespace kinect_ekf_slam {

std::string one_line(std::string text, std::size_t longest) {
  if (text.size() > longest) text = text.substr(0, longest) + "...";
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

}  // namespace kinect_ekf_slam
