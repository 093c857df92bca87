#include "kinect_ekf_slam/simulation/scene.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/random_stream.h"

namespace kinect_ekf_slam {

Rgb paint(const std::string& label) {
  static const std::map<std::string, Rgb> kPaints{{"red", {190, 35, 30}},      {"orange", {220, 110, 25}},
                                                  {"yellow", {215, 190, 30}},  {"green", {40, 150, 50}},
                                                  {"cyan", {30, 170, 190}},    {"blue", {35, 70, 180}},
                                                  {"magenta", {190, 40, 150}}, {"purple", {120, 45, 160}}};
  const auto found = kPaints.find(label);
  return found != kPaints.end() ? found->second : Rgb{140, 140, 140};
}

Rgb Texture::at(double along, double down) const {
  const int column = std::clamp(static_cast<int>(along * columns), 0, columns - 1);
  const int row = std::clamp(static_cast<int>(down * rows), 0, rows - 1);
  return pixels[static_cast<std::size_t>(row) * columns + column];
}

void Scene::add_ball(const Eigen::Vector3d& center_in_world, double radius, const Rgb& colour) {
  constexpr int kSlices = 8;
  const auto height = [&](int slice) { return -radius * std::cos(kPi * slice / kSlices); };
  const auto width = [&](int slice) { return radius * std::sin(kPi * slice / kSlices); };
  for (int i = 0; i < kSlices; ++i) {
    const Eigen::Vector3d foot = center_in_world + Eigen::Vector3d(0.0, 0.0, height(i));
    bodies.push_back({foot, {0.0, 0.0, height(i + 1) - height(i)}, width(i), width(i + 1), colour});
  }
}

void Scene::add_box(const Eigen::Vector2d& place_in_world, double yaw, const Eigen::Vector3d& size,
                    const Rgb& colour) {
  const Eigen::Vector3d ahead = size.x() * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.0);
  const Eigen::Vector3d left = size.y() * Eigen::Vector3d(-std::sin(yaw), std::cos(yaw), 0.0);
  const Eigen::Vector3d up(0.0, 0.0, size.z());
  const Eigen::Vector3d place(place_in_world.x(), place_in_world.y(), 0.0);
  const Eigen::Vector3d corner = place - 0.5 * ahead - 0.5 * left + up;
  const Texture texture(colour);
  panels.push_back({corner, ahead, left, texture});  // the top
  panels.push_back({corner, ahead, -up, texture});
  panels.push_back({corner, left, -up, texture});
  panels.push_back({corner + left, ahead, -up, texture});
  panels.push_back({corner + ahead, left, -up, texture});
}

Texture printed(const std::vector<std::string>& rows) {
  constexpr Rgb kWhite{235, 235, 235};
  constexpr Rgb kBlack{25, 25, 25};
  const std::size_t modules = rows.empty() ? 0 : rows.front().size();
  const auto columns = static_cast<int>(modules + 2);
  Texture texture(columns, static_cast<int>(rows.size() + 2),
                  std::vector<Rgb>((modules + 2) * (rows.size() + 2), kWhite));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t column = 0; column < modules; ++column) {
      if (rows[row][column] == '#') texture.pixels[(row + 1) * (modules + 2) + column + 1] = kBlack;
    }
  }
  return texture;
}

Panel upright_panel(const Eigen::Vector3d& center_in_world, double facing, double size,
                    const Texture& texture) {
  const Eigen::Vector3d along = size * Eigen::Vector3d(-std::sin(facing), std::cos(facing), 0.0);
  const Eigen::Vector3d down(0.0, 0.0, -size);
  return {center_in_world - 0.5 * along - 0.5 * down, along, down, texture};
}

Texture blotches(int columns, int rows, std::uint64_t seed) {
  constexpr int kPixelsPerBlotch = 40;
  RandomStream random(seed, 0);
  const auto channel = [&] { return static_cast<std::uint8_t>(random.uniform(20.0, 235.0)); };
  Texture texture(columns, rows,
                  std::vector<Rgb>(static_cast<std::size_t>(columns) * rows, Rgb{150, 150, 150}));
  for (int i = 0; i < columns * rows / kPixelsPerBlotch; ++i) {
    const int left = static_cast<int>(random.index(columns));
    const int top = static_cast<int>(random.index(rows));
    const int right = std::min(columns, left + 2 + static_cast<int>(random.index(14)));
    const int bottom = std::min(rows, top + 2 + static_cast<int>(random.index(14)));
    const std::uint8_t red = channel();
    const std::uint8_t green = channel();
    const Rgb colour{red, green, channel()};
    for (int row = top; row < bottom; ++row) {
      for (int column = left; column < right; ++column) {
        texture.pixels[static_cast<std::size_t>(row) * columns + column] = colour;
      }
    }
  }
  return texture;
}

}  // namespace kinect_ekf_slam
