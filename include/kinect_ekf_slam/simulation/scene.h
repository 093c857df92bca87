#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kinect_ekf_slam {

struct Rgb {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
};

/// How something with that label is painted; grey for a label that names no colour.
Rgb paint(const std::string& label);

/// A pattern on a rectangle, row after row from its upper left corner; a single pixel is one colour.
struct Texture {
  int columns = 1;
  int rows = 1;
  std::vector<Rgb> pixels{Rgb{128, 128, 128}};

  Texture() = default;
  explicit Texture(Rgb colour) : pixels{colour} {}
  Texture(int columns_, int rows_, std::vector<Rgb> pixels_)
      : columns(columns_), rows(rows_), pixels(std::move(pixels_)) {}

  /// 0 to 1 along the upper edge, 0 to 1 down.
  Rgb at(double along, double down) const;
};

/// A rectangle; both sides are seen.
struct Panel {
  Eigen::Vector3d corner_in_world = Eigen::Vector3d::Zero();  ///< m, upper left one
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();           ///< m, the whole upper edge
  Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();           ///< m, the whole left edge
  Texture texture;
};

/// A round body with flat ends: a cylinder, or a cone cut off.
struct RoundBody {
  Eigen::Vector3d foot_in_world = Eigen::Vector3d::Zero();  ///< m, where the axis begins
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();          ///< m, the whole of it
  double foot_radius = 0.05;                                ///< m
  double top_radius = 0.05;                                 ///< m
  Rgb colour;
};

/// What a simulated camera looks at.
struct Scene {
  std::vector<Panel> panels;
  std::vector<RoundBody> bodies;
  double brightness = 1.0;  ///< of the light; 1 shows colours as they are where it falls straight on

  /// A ball, near enough: slices that are cones cut off.
  void add_ball(const Eigen::Vector3d& center_in_world, double radius, const Rgb& colour);

  /// Five panels: a box that stands on the floor, turned about the vertical.
  void add_box(const Eigen::Vector2d& place_in_world, double yaw, const Eigen::Vector3d& size,
               const Rgb& colour);
};

/// Black where the rows of text have `#`, white elsewhere and on a margin of one module around.
Texture printed(const std::vector<std::string>& rows);

/// An upright square panel; `facing` is the direction that its printed side looks to, rad from the world's X.
Panel upright_panel(const Eigen::Vector3d& center_in_world, double facing, double size,
                    const Texture& texture);

/// A pattern of blotches without repetition, for feature detectors to find their way; fixed by its seed.
Texture blotches(int columns, int rows, std::uint64_t seed);

}  // namespace kinect_ekf_slam
