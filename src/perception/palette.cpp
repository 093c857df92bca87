#include "kinect_ekf_slam/perception/palette.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace kinect_ekf_slam {
namespace {

constexpr double kFullTurn = 360.0;  // degrees of hue

/// Hue, saturation and value of a pixel, in degrees and shares.
struct Hsv {
  double hue_deg;
  double saturation;
  double value;
  double second;  ///< the middle channel, 0 to 1
};

Hsv to_hsv(const cv::Vec3b& pixel) {
  constexpr double kFull = 255.0;
  const double blue = pixel[0] / kFull;
  const double green = pixel[1] / kFull;
  const double red = pixel[2] / kFull;
  const double most = std::max({red, green, blue});
  const double least = std::min({red, green, blue});
  const double chroma = most - least;
  double sector = 0.0;
  if (chroma > 0.0) {
    if (most == red) {
      sector = (green - blue) / chroma;
    } else if (most == green) {
      sector = 2.0 + (blue - red) / chroma;
    } else {
      sector = 4.0 + (red - green) / chroma;
    }
  }
  const double hue = std::fmod(60.0 * sector + kFullTurn, kFullTurn);
  return {hue, most > 0.0 ? chroma / most : 0.0, most, red + green + blue - most - least};
}

bool has_hue(const PaletteColour& colour, double hue_deg) {
  if (colour.hue_min_deg <= colour.hue_max_deg) {
    return hue_deg >= colour.hue_min_deg && hue_deg < colour.hue_max_deg;
  }
  return hue_deg >= colour.hue_min_deg || hue_deg < colour.hue_max_deg;
}

double number(const YAML::Node& node, const std::string& key, double low, double high,
              const std::string& name) {
  double value = 0.0;
  if (!node || !node.IsScalar() || !YAML::convert<double>::decode(node, value) || !(value >= low) ||
      !(value <= high)) {
    std::ostringstream line;
    line << name << ": " << key << ": allowed: a number from " << low << " to " << high;
    throw PaletteError(line.str());
  }
  return value;
}

PaletteColour read_colour(const std::string& label, const YAML::Node& hues, const std::string& name) {
  const std::string key = "colours/" + label;
  if (!hues.IsSequence() || hues.size() != 2) {
    throw PaletteError(name + ": " + key + ": allowed: [least hue, largest hue] in degrees");
  }
  return {label, number(hues[0], key, 0.0, kFullTurn, name), number(hues[1], key, 0.0, kFullTurn, name)};
}

Palette read(const YAML::Node& root, const std::string& name) {
  if (!root.IsMap()) throw PaletteError(name + ": allowed: a map of keys and values");
  Palette palette;
  for (const auto& entry : root) {
    const auto key = entry.first.as<std::string>();
    if (key == "colours" && entry.second.IsMap()) {
      for (const auto& colour : entry.second) {
        palette.colours.push_back(read_colour(colour.first.as<std::string>(), colour.second, name));
      }
    } else if (key == "smallest_saturation") {
      palette.smallest_saturation = number(entry.second, key, 0.0, 1.0, name);
    } else if (key == "smallest_value") {
      palette.smallest_value = number(entry.second, key, 0.0, 1.0, name);
    } else if (key == "largest_value") {
      palette.largest_value = number(entry.second, key, 0.0, 1.0, name);
    } else if (key == "smallest_share") {
      palette.smallest_share = number(entry.second, key, 0.0, 1.0, name);
    } else {
      throw PaletteError(name + ": " + key +
                         ": is not known, allowed: colours (a map), smallest_saturation, smallest_value, "
                         "largest_value, smallest_share");
    }
  }
  if (palette.colours.empty()) throw PaletteError(name + ": colours: is missing, allowed: label: [hue, hue]");
  return palette;
}

}  // namespace

Palette parse_palette(const std::string& yaml, const std::string& name) {
  try {
    return read(YAML::Load(yaml), name);
  } catch (const YAML::Exception& error) {
    throw PaletteError(name + ": not YAML: " + error.what());
  }
}

Palette read_palette(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!(text << file.rdbuf())) throw PaletteError(path + ": cannot be read");
  return parse_palette(text.str(), path);
}

std::string colour_label(const std::vector<cv::Vec3b>& pixels, const Palette& palette) {
  std::vector<std::size_t> votes(palette.colours.size(), 0);
  for (const cv::Vec3b& pixel : pixels) {
    const Hsv hsv = to_hsv(pixel);
    if (hsv.saturation < palette.smallest_saturation || hsv.value < palette.smallest_value ||
        hsv.second > palette.largest_value) {
      continue;
    }
    for (std::size_t i = 0; i < votes.size(); ++i)
      votes[i] += has_hue(palette.colours[i], hsv.hue_deg) ? 1 : 0;
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  const double needed = palette.smallest_share * static_cast<double>(pixels.size());
  if (most == votes.end() || *most == 0 || static_cast<double>(*most) < needed) return kUnknownColour;
  return palette.colours[most - votes.begin()].label;
}

}  // namespace kinect_ekf_slam
