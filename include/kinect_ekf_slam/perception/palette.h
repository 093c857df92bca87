#pragma once

#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinect_ekf_slam {

/// A hue that stands for a label.
struct PaletteColour {
  std::string label;
  double hue_min_deg = 0.0;  ///< 0 red, 120 green, 240 blue
  double hue_max_deg = 0.0;  ///< smaller than the least one: the range goes through 0
};

/// What a surface must show to be given a colour.
struct Palette {
  std::vector<PaletteColour> colours;
  double smallest_saturation = 0.35;  ///< 0 grey, 1 pure; below, a pixel's hue is chance
  double smallest_value = 0.12;       ///< of its brightest channel, 0 to 1; below, a pixel is in the dark
  double smallest_share = 0.5;        ///< of all pixels that must have the colour
};

/// One line that names the file, the key and what is allowed.
class PaletteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a palette (config/palette.yaml explains the keys). Throws PaletteError.
Palette read_palette(const std::string& path);
/// The same from text; `name` stands for the file in errors.
Palette parse_palette(const std::string& yaml, const std::string& name);

constexpr const char* kUnknownColour = "unknown";

/// The colour that most of the pixels (blue green red) have by their hue: shade and exposure change a
/// surface's brightness and its saturation, but hardly its hue. kUnknownColour when too few agree.
std::string colour_label(const std::vector<cv::Vec3b>& pixels, const Palette& palette);

}  // namespace kinect_ekf_slam
