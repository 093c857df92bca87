#include "kinect_ekf_slam/perception/palette.h"

#include <gtest/gtest.h>

#include <random>

namespace kinect_ekf_slam {
namespace {

Palette red_green_blue() {
  return parse_palette("colours: {red: [340, 20], green: [80, 160], blue: [200, 260]}", "test");
}

/// A surface of that colour (blue green red, 0 to 1) under a light of that strength, with a shaded side.
std::vector<cv::Vec3b> surface(const cv::Vec3d& colour, double light, std::mt19937_64* random) {
  std::normal_distribution<double> noise(0.0, 4.0);
  std::vector<cv::Vec3b> pixels;
  for (int i = 0; i < 400; ++i) {
    const double shade = light * (0.35 + 0.65 * i / 400.0);
    cv::Vec3b pixel;
    for (int c = 0; c < 3; ++c)
      pixel[c] = cv::saturate_cast<uchar>(255.0 * shade * colour[c] + noise(*random));
    pixels.push_back(pixel);
  }
  return pixels;
}

TEST(ColourLabel, HoldsFromDeepShadeToBrightLight) {
  std::mt19937_64 random(1);
  for (const double light : {0.4, 0.7, 1.0, 1.3}) {
    EXPECT_EQ(colour_label(surface({0.1, 0.1, 0.8}, light, &random), red_green_blue()), "red") << light;
    EXPECT_EQ(colour_label(surface({0.15, 0.7, 0.1}, light, &random), red_green_blue()), "green") << light;
    EXPECT_EQ(colour_label(surface({0.8, 0.2, 0.1}, light, &random), red_green_blue()), "blue") << light;
  }
}

TEST(ColourLabel, HoldsUnderATintedLamp) {
  std::mt19937_64 random(2);
  for (const cv::Vec3d& lamp : {cv::Vec3d(0.8, 0.95, 1.0), cv::Vec3d(1.0, 0.95, 0.85)}) {
    const auto lit = [&](const cv::Vec3d& colour) { return surface(colour.mul(lamp), 0.9, &random); };
    EXPECT_EQ(colour_label(lit({0.1, 0.1, 0.8}), red_green_blue()), "red");
    EXPECT_EQ(colour_label(lit({0.15, 0.7, 0.1}), red_green_blue()), "green");
    EXPECT_EQ(colour_label(lit({0.8, 0.2, 0.1}), red_green_blue()), "blue");
  }
}

TEST(ColourLabel, GreyDarkAndMixedAreUnknown) {
  std::mt19937_64 random(3);
  EXPECT_EQ(colour_label(surface({0.6, 0.6, 0.6}, 1.0, &random), red_green_blue()), kUnknownColour);
  EXPECT_EQ(colour_label(surface({0.1, 0.1, 0.8}, 0.05, &random), red_green_blue()), kUnknownColour);
  std::vector<cv::Vec3b> mixed = surface({0.1, 0.1, 0.8}, 0.9, &random);
  const std::vector<cv::Vec3b> other = surface({0.15, 0.7, 0.1}, 0.9, &random);
  mixed.insert(mixed.end(), other.begin(), other.end());
  mixed.insert(mixed.end(), other.size() / 10, cv::Vec3b(128, 128, 128));
  EXPECT_EQ(colour_label(mixed, red_green_blue()), kUnknownColour);
  EXPECT_EQ(colour_label({}, red_green_blue()), kUnknownColour);
}

TEST(PaletteFile, WrongOnesAreRefusedInOneLine) {
  const auto message = [](const std::string& yaml) -> std::string {
    try {
      parse_palette(yaml, "p.yaml");
    } catch (const PaletteError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message("colours: {red: [340, 20]}"), "accepted");
  for (const auto& [yaml, part] : {std::pair<std::string, std::string>{"colours: {red: [400, 20]}", "red"},
                                   {"colours: {red: 3}", "red"},
                                   {"colours: {red: [0, 20]}\nhues: 3", "hues"},
                                   {"colours: {red: [0, 20]}\nsmallest_share: 2", "smallest_share"},
                                   {"smallest_share: 0.5", "colours"},
                                   {"colours: [", "not YAML"}}) {
    EXPECT_NE(message(yaml).find(part), std::string::npos) << message(yaml);
    EXPECT_EQ(message(yaml).rfind("p.yaml: ", 0), 0U) << message(yaml);
  }
  EXPECT_THROW(read_palette("/nowhere/palette.yaml"), PaletteError);
}

}  // namespace
}  // namespace kinect_ekf_slam
