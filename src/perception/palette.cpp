#include "kinect_ekf_slam/perception/palette.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

namespace kinect_ekf_slam {
namespace {

constexpr double kFullTurn = 360.0;  // degrees of hue

/// Hue, saturation and value of a pixel, in degrees and shares.
struct Hsv {
  double hue_deg;
  double saturation;
  double value;
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
  return {hue, most > 0.0 ? chroma / most : 0.0, most};
}

bool has_hue(const PaletteColour& colour, double hue_deg) {
  if (colour.hue_min_deg <= colour.hue_max_deg) {
    return hue_deg >= colour.hue_min_deg && hue_deg < colour.hue_max_deg;
  }
  return hue_deg >= colour.hue_min_deg || hue_deg < colour.hue_max_deg;
}

[[noreturn]] void fail(const std::string& name, const std::string& key, const std::string& allowed) {
  throw PaletteError(std::string(name).append(": ").append(key).append(": allowed: ").append(allowed));
}

double number(const YAML::Node& node, const std::string& key, double high, const std::string& name) {
  double value = 0.0;
  const bool is_number = node.IsScalar() && YAML::convert<double>::decode(node, value);
  if (!is_number || !(value >= 0.0 && value <= high)) {
    std::ostringstream allowed;
    allowed << "a number from 0 to " << high;
    fail(name, key, allowed.str());
  }
  return value;
}

PaletteColour read_colour(const std::string& label, const YAML::Node& hues, const std::string& name) {
  const std::string key = std::string("colours/").append(label);
  if (!hues.IsSequence() || hues.size() != 2) fail(name, key, "[from, to] in degrees");
  return {label, number(hues[0], key, kFullTurn, name), number(hues[1], key, kFullTurn, name)};
}

Palette read(const YAML::Node& root, const std::string& name) {
  if (!root.IsMap()) fail(name, "palette", "a map of keys and values");
  Palette palette;
  const std::map<std::string, double*> shares{{"smallest_saturation", &palette.smallest_saturation},
                                              {"smallest_value", &palette.smallest_value},
                                              {"smallest_share", &palette.smallest_share}};
  for (const auto& entry : root) {
    const auto key = entry.first.as<std::string>();
    if (const auto share = shares.find(key); share != shares.end()) {
      *share->second = number(entry.second, key, 1.0, name);
    } else if (key == "colours" && entry.second.IsMap()) {
      for (const auto& colour : entry.second) {
        palette.colours.push_back(read_colour(colour.first.as<std::string>(), colour.second, name));
      }
    } else {
      fail(name, key, "colours (a map), smallest_saturation, smallest_value, smallest_share");
    }
  }
  if (palette.colours.empty()) fail(name, "colours", "label: [from, to], at least one");
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
    if (hsv.saturation < palette.smallest_saturation || hsv.value < palette.smallest_value) continue;
    for (std::size_t i = 0; i < votes.size(); ++i)
      votes[i] += has_hue(palette.colours[i], hsv.hue_deg) ? 1 : 0;
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  const double needed = palette.smallest_share * static_cast<double>(pixels.size());
  if (most == votes.end() || *most == 0 || static_cast<double>(*most) < needed) return kUnknownColour;
  return palette.colours[most - votes.begin()].label;
}

}  // namespace kinect_ekf_slam
