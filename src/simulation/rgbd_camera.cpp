#include "kinect_ekf_slam/simulation/rgbd_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace kinect_ekf_slam {
namespace {

constexpr double kNearest = 0.05;  // m; what is nearer to the camera is not drawn
constexpr float kNothing = std::numeric_limits<float>::infinity();

/// Where a ray (of depth 1) meets a surface.
struct Hit {
  double depth = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< in the world, either side
  Rgb colour;
};

Rgb lit(const Rgb& colour, const Eigen::Vector3d& normal, double brightness) {
  const Eigen::Vector3d to_light = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  constexpr double kAmbient = 0.55;
  const double light = brightness * (kAmbient + (1.0 - kAmbient) * std::abs(normal.dot(to_light)));
  const auto scaled = [&](std::uint8_t channel) {
    return static_cast<std::uint8_t>(std::min(255.0, light * channel));
  };
  return {scaled(colour.red), scaled(colour.green), scaled(colour.blue)};
}

/// The nearest of the two parameters at which a ray meets a plane or a quadric and that `accept` takes.
template <class Accept>
std::optional<double> nearest_root(double a, double b, double c, const Accept& accept) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0 || std::abs(a) < 1e-15) return std::nullopt;
  const double root = std::sqrt(discriminant);
  const double first = std::min((-b - root) / a, (-b + root) / a);
  const double second = std::max((-b - root) / a, (-b + root) / a);
  for (const double depth : {first, second}) {
    if (depth > kNearest && accept(depth)) return depth;
  }
  return std::nullopt;
}

/// A panel as the rays of one camera meet it.
class PanelCaster {
 public:
  PanelCaster(const Panel& panel, const Eigen::Vector3d& eye)
      : panel_(panel),
        normal_(panel.along.cross(panel.down).normalized()),
        from_corner_(eye - panel.corner_in_world),
        distance_(normal_.dot(from_corner_)),
        along_(panel.along / panel.along.squaredNorm()),
        down_(panel.down / panel.down.squaredNorm()) {}

  std::vector<Eigen::Vector3d> corners() const {
    const Eigen::Vector3d& corner = panel_.corner_in_world;
    return {corner, corner + panel_.along, corner + panel_.down, corner + panel_.along + panel_.down};
  }

  std::optional<Hit> cast(const Eigen::Vector3d& ray) const {
    const double approach = normal_.dot(ray);
    if (std::abs(approach) < 1e-12) return std::nullopt;
    const double depth = -distance_ / approach;
    if (!(depth > kNearest)) return std::nullopt;
    const Eigen::Vector3d offset = from_corner_ + depth * ray;
    const double along = along_.dot(offset);
    const double down = down_.dot(offset);
    if (along < 0.0 || along > 1.0 || down < 0.0 || down > 1.0) return std::nullopt;
    return Hit{depth, normal_, panel_.texture.at(along, down)};
  }

 private:
  const Panel& panel_;
  Eigen::Vector3d normal_;
  Eigen::Vector3d from_corner_;
  double distance_;
  Eigen::Vector3d along_;
  Eigen::Vector3d down_;
};

/// A round body likewise; computes in its own axes, Z along the axis from the foot.
class BodyCaster {
 public:
  BodyCaster(const RoundBody& body, const Eigen::Vector3d& eye)
      : body_(body),
        height_(body.axis.norm()),
        slope_((body.top_radius - body.foot_radius) / height_),
        body_from_world_(Eigen::Quaterniond::FromTwoVectors(body.axis, Eigen::Vector3d::UnitZ()).matrix()),
        eye_(body_from_world_ * (eye - body.foot_in_world)) {}

  std::vector<Eigen::Vector3d> corners() const {
    const double radius = std::max(body_.foot_radius, body_.top_radius);
    std::vector<Eigen::Vector3d> corners;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d in_body((i & 1) != 0 ? radius : -radius, (i & 2) != 0 ? radius : -radius,
                                    (i & 4) != 0 ? height_ : 0.0);
      corners.push_back(body_.foot_in_world + body_from_world_.transpose() * in_body);
    }
    return corners;
  }

  std::optional<Hit> cast(const Eigen::Vector3d& ray_in_world) const {
    const Eigen::Vector3d ray = body_from_world_ * ray_in_world;
    // x^2 + y^2 = (r + slope z)^2 along the ray.
    const double radius_at_eye = body_.foot_radius + slope_ * eye_.z();
    const double growth = slope_ * ray.z();
    const double a = ray.head<2>().squaredNorm() - growth * growth;
    const double b = eye_.head<2>().dot(ray.head<2>()) - radius_at_eye * growth;
    const double c = eye_.head<2>().squaredNorm() - radius_at_eye * radius_at_eye;
    const auto wall = nearest_root(a, b, c, [&](double depth) {
      const double height = eye_.z() + depth * ray.z();
      return height >= 0.0 && height <= height_;
    });
    std::optional<Hit> hit;
    if (wall) {
      const Eigen::Vector3d point = eye_ + *wall * ray;
      const Eigen::Vector2d outwards = point.head<2>().normalized();
      hit = to_hit(*wall, Eigen::Vector3d(outwards.x(), outwards.y(), -slope_).normalized());
    }
    for (const auto& [height, radius] : {std::pair{0.0, body_.foot_radius}, {height_, body_.top_radius}}) {
      const double depth = (height - eye_.z()) / ray.z();
      const bool on_lid = depth > kNearest && (eye_ + depth * ray).head<2>().norm() <= radius;
      if (on_lid && (!hit || depth < hit->depth)) hit = to_hit(depth, Eigen::Vector3d::UnitZ());
    }
    return hit;
  }

 private:
  Hit to_hit(double depth, const Eigen::Vector3d& normal_in_body) const {
    return {depth, body_from_world_.transpose() * normal_in_body, body_.colour};
  }

  const RoundBody& body_;
  double height_;
  double slope_;  ///< change of radius over height
  Eigen::Matrix3d body_from_world_;
  Eigen::Vector3d eye_;  ///< in the body's axes
};

/// Draws surfaces one after the other; the nearest stays.
class Canvas {
 public:
  Canvas(const Eigen::Isometry3d& world_from_optical, const RgbdCameraOptions& options, double brightness)
      : options_(options),
        brightness_(brightness),
        world_from_optical_(world_from_optical),
        columns_(options.width * options.samples),
        rows_(options.height * options.samples),
        focal_length_(options.focal_length * options.samples),
        colour_(static_cast<std::size_t>(columns_) * rows_),
        depth_(colour_.size(), kNothing),
        incidence_(colour_.size(), 0.0F) {}

  const Eigen::Isometry3d& world_from_optical() const { return world_from_optical_; }

  template <class Caster>
  void draw(const Caster& caster) {
    const auto [left, right, top, bottom] = window_of(caster.corners());
    for (int row = top; row < bottom; ++row) {
      for (int column = left; column < right; ++column) {
        const Eigen::Vector3d ray = world_from_optical_.linear() * ray_of(column, row);
        const std::optional<Hit> hit = caster.cast(ray);
        const std::size_t index = static_cast<std::size_t>(row) * columns_ + column;
        if (!hit || hit->depth >= depth_[index]) continue;
        depth_[index] = static_cast<float>(hit->depth);
        incidence_[index] = static_cast<float>(std::abs(hit->normal.dot(ray)) / ray.norm());
        colour_[index] = lit(hit->colour, hit->normal, brightness_);
      }
    }
  }

  RgbdImage picture() const {
    const int samples = options_.samples;
    RgbdImage image{options_.width, options_.height, {}, {}, {}};
    for (int row = 0; row < options_.height; ++row) {
      for (int column = 0; column < options_.width; ++column) {
        const std::size_t middle_row = static_cast<std::size_t>(row) * samples + samples / 2;
        const std::size_t middle =
            middle_row * columns_ + static_cast<std::size_t>(column) * samples + samples / 2;
        image.depth.push_back(depth_[middle] == kNothing ? 0.0F : depth_[middle]);
        image.incidence.push_back(incidence_[middle]);
        image.colour.push_back(mean_colour(row * samples, column * samples));
      }
    }
    return image;
  }

 private:
  struct Window {
    int left;
    int right;
    int top;
    int bottom;
  };

  Eigen::Vector3d ray_of(int column, int row) const {
    return {(column - 0.5 * (columns_ - 1)) / focal_length_, (row - 0.5 * (rows_ - 1)) / focal_length_, 1.0};
  }

  /// The pixels that a body with those corners can cover.
  Window window_of(const std::vector<Eigen::Vector3d>& corners_in_world) const {
    double left = columns_;
    double right = 0.0;
    double top = rows_;
    double bottom = 0.0;
    for (const Eigen::Vector3d& corner : corners_in_world) {
      const Eigen::Vector3d point = world_from_optical_.inverse() * corner;
      if (point.z() < kNearest) return {0, columns_, 0, rows_};
      const double column = focal_length_ * point.x() / point.z() + 0.5 * (columns_ - 1);
      const double row = focal_length_ * point.y() / point.z() + 0.5 * (rows_ - 1);
      left = std::min(left, column);
      right = std::max(right, column);
      top = std::min(top, row);
      bottom = std::max(bottom, row);
    }
    const auto inside = [](double value, int size) {
      return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
    };
    return {inside(left, columns_), inside(right + 2.0, columns_), inside(top, rows_),
            inside(bottom + 2.0, rows_)};
  }

  Rgb mean_colour(int top, int left) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < options_.samples; ++i) {
      for (int j = 0; j < options_.samples; ++j) {
        const Rgb& colour = colour_[static_cast<std::size_t>(top + i) * columns_ + left + j];
        sum += Eigen::Vector3d(colour.red, colour.green, colour.blue);
      }
    }
    sum /= options_.samples * options_.samples;
    return {static_cast<std::uint8_t>(std::lround(sum.x())), static_cast<std::uint8_t>(std::lround(sum.y())),
            static_cast<std::uint8_t>(std::lround(sum.z()))};
  }

  const RgbdCameraOptions& options_;
  double brightness_;
  Eigen::Isometry3d world_from_optical_;
  int columns_;
  int rows_;
  double focal_length_;
  std::vector<Rgb> colour_;
  std::vector<float> depth_;
  std::vector<float> incidence_;
};

/// Along a row or column: the mean disparity of the nearest surface within half a window. So a near surface
/// covers a farther one beyond its edge, and what is rough or bent becomes smoother.
void compare_windows(int half_window, int count, std::ptrdiff_t stride, float* depths) {
  constexpr float kSameSurface = 1.05F;  // times the nearest depth
  std::vector<float> line(count);
  for (int i = 0; i < count; ++i) line[i] = depths[i * stride] > 0.0F ? depths[i * stride] : kNothing;
  for (int i = 0; i < count; ++i) {
    const auto first = line.begin() + std::max(0, i - half_window);
    const auto last = line.begin() + std::min(count, i + half_window + 1);
    const float farthest = kSameSurface * *std::min_element(first, last);
    float sum = 0.0F;
    float readings = 0.0F;
    for (auto depth = first; farthest < kNothing && depth != last; ++depth) {
      if (*depth > farthest) continue;
      sum += 1.0F / *depth;
      readings += 1.0F;
    }
    depths[i * stride] = readings > 0.0F ? readings / sum : 0.0F;
  }
}

/// The projector stands right of the camera: what it cannot see is left of what hides it.
void cast_shadow(double baseline_pixels, int width, float* depths) {
  double leftmost = std::numeric_limits<double>::infinity();  // projector's column of what is further right
  for (int column = width - 1; column >= 0; --column) {
    if (depths[column] == 0.0F) continue;
    const double in_projector = column - baseline_pixels / depths[column];
    if (in_projector > leftmost + 1.0) {
      depths[column] = 0.0F;
    } else {
      leftmost = std::min(leftmost, in_projector);
    }
  }
}

}  // namespace

RgbdImage render(const Scene& scene, const Eigen::Isometry3d& world_from_optical,
                 const RgbdCameraOptions& options) {
  Canvas canvas(world_from_optical, options, scene.brightness);
  const Eigen::Vector3d eye = world_from_optical.translation();
  for (const Panel& panel : scene.panels) canvas.draw(PanelCaster(panel, eye));
  for (const RoundBody& body : scene.bodies) canvas.draw(BodyCaster(body, eye));
  return canvas.picture();
}

void add_kinect_errors(const RgbdCameraOptions& options, RandomStream* random, RgbdImage* image) {
  std::vector<float>& depth = image->depth;
  const int width = image->width;
  const int height = image->height;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (image->incidence[i] < options.grazing_cosine) depth[i] = 0.0F;
  }
  for (int row = 0; row < height; ++row) {
    compare_windows(options.half_window, width, 1, &depth[static_cast<std::size_t>(row) * width]);
  }
  for (int column = 0; column < width; ++column) {
    compare_windows(options.half_window, height, width, &depth[column]);
  }
  for (int row = 0; row < height; ++row) {
    cast_shadow(options.focal_length * options.shadow_baseline, width,
                &depth[static_cast<std::size_t>(row) * width]);
  }
  for (float& reading : depth) {
    if (reading == 0.0F) continue;
    double steps = 1.0 / (options.step_per_m * options.depth_scale * reading);
    steps = std::round(steps + options.sigma_per_m / options.step_per_m * random->normal());
    reading = static_cast<float>(1.0 / (options.step_per_m * steps));
    const bool in_range = reading >= options.min_depth && reading <= options.max_depth;
    if (!in_range || random->chance(options.missing_rate)) reading = 0.0F;
  }
  for (Rgb& pixel : image->colour) {
    for (std::uint8_t* channel : {&pixel.red, &pixel.green, &pixel.blue}) {
      const double noisy = *channel + options.colour_sigma * random->normal();
      *channel = static_cast<std::uint8_t>(std::clamp(noisy, 0.0, 255.0));
    }
  }
}

}  // namespace kinect_ekf_slam
