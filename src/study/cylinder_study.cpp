#include "kinect_ekf_slam/study/cylinder_study.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/study/simulated_picture.h"
#include "kinect_ekf_slam/study/thread_time.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kMatchDistance = 0.1;  // m, between a finding and the axis point of a cylinder

constexpr const char* kLabels[] = {"red", "green", "blue", "yellow"};

Rgb grey(RandomStream* random) {
  const auto level = static_cast<std::uint8_t>(random->uniform(80.0, 200.0));
  return {level, level, level};
}

/// Puts things on the floor so that none stands in another.
class Stage {
 public:
  Stage(RandomStream* random, CylinderView* view) : random_(random), view_(view) {}

  void add_cylinder() {
    const double radius = random_->uniform(0.05, 0.10);
    RoundBody body;
    body.foot_in_world = free_place(0.6, 2.8, radius);
    body.axis = Eigen::Vector3d(0.0, 0.0, random_->uniform(0.3, 0.5));
    body.foot_radius = body.top_radius = radius;
    body.colour = paint(kLabels[random_->index(std::size(kLabels))]);
    view_->cylinders.push_back(body);
    view_->scene.bodies.push_back(body);
  }

  void add_box() {
    const Eigen::Vector3d size(random_->uniform(0.06, 0.3), random_->uniform(0.06, 0.3),
                               random_->uniform(0.1, 0.5));
    const Eigen::Vector3d place = free_place(0.8, 3.0, 0.5 * size.head<2>().norm());
    view_->scene.add_box(place.head<2>(), random_->uniform(-kPi, kPi), size, grey(random_));
  }

  /// A bowl, upright or upside down.
  void add_bowl() {
    RoundBody body;
    body.foot_in_world = free_place(0.7, 2.0, 0.1);
    body.axis = Eigen::Vector3d(0.0, 0.0, random_->uniform(0.06, 0.1));
    body.foot_radius = random_->uniform(0.04, 0.06);
    body.top_radius = random_->uniform(0.09, 0.11);
    if (random_->chance(0.5)) std::swap(body.foot_radius, body.top_radius);
    body.colour = grey(random_);
    view_->scene.bodies.push_back(body);
  }

  /// Two legs of a person who stands there.
  void add_legs() {
    const Eigen::Vector3d place = free_place(0.9, 2.8, 0.25);
    const double direction = random_->uniform(-kPi, kPi);
    for (const double side : {-0.1, 0.1}) {
      RoundBody leg;
      leg.foot_in_world = place + side * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
      leg.axis = Eigen::Vector3d(0.0, 0.0, 0.85);
      leg.foot_radius = random_->uniform(0.05, 0.06);
      leg.top_radius = 0.085;
      leg.colour = {40, 50, 90};
      view_->scene.bodies.push_back(leg);
    }
  }

  void add_roll() {
    RoundBody body;
    const double radius = random_->uniform(0.03, 0.06);
    const double direction = random_->uniform(-kPi, kPi);
    body.axis = random_->uniform(0.15, 0.3) * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
    body.foot_in_world = free_place(0.7, 2.2, 0.2) - 0.5 * body.axis + Eigen::Vector3d(0.0, 0.0, radius);
    body.foot_radius = body.top_radius = radius;
    body.colour = grey(random_);
    view_->scene.bodies.push_back(body);
  }

 private:
  /// In front of the camera, which stands over the origin and looks along X.
  Eigen::Vector3d free_place(double nearest, double farthest, double radius) {
    constexpr double kGap = 0.06;  // m
    constexpr int kTries = 200;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (int i = 0; i < kTries; ++i) {
      const double distance = random_->uniform(nearest, farthest);
      const double aside = random_->uniform(-0.5, 0.5) * distance;
      place = Eigen::Vector3d(distance, aside, 0.0);
      const bool is_free = std::all_of(taken_.begin(), taken_.end(), [&](const Eigen::Vector3d& other) {
        return (other.head<2>() - place.head<2>()).norm() > other.z() + radius + kGap;
      });
      if (is_free) break;
    }
    taken_.emplace_back(place.x(), place.y(), radius);
    return place;
  }

  RandomStream* random_;
  CylinderView* view_;
  std::vector<Eigen::Vector3d> taken_;  ///< x, y, radius
};

void add_room(RandomStream* random, Scene* scene) {
  constexpr double kSize = 12.0;  // m
  const Rgb floor = grey(random);
  scene->panels.push_back(
      {{-0.5 * kSize, -0.5 * kSize, 0.0}, {kSize, 0.0, 0.0}, {0.0, kSize, 0.0}, Texture(floor)});
  const double wall = random->uniform(3.2, 4.5);
  const double turn = random->uniform(-0.5, 0.5);
  const Eigen::Vector3d along = kSize * Eigen::Vector3d(std::sin(turn), std::cos(turn), 0.0);
  scene->panels.push_back(
      {Eigen::Vector3d(wall, 0.0, 2.5) - 0.5 * along, along, {0.0, 0.0, -2.5}, Texture(grey(random))});
}

/// The sightline to the axis, at the height of the camera: bearing and half the angle that the body takes.
struct Sight {
  double distance;
  double bearing;
  double half_width;
};

Sight sight_of(const Eigen::Vector2d& place, double radius) {
  return {place.norm(), std::atan2(place.y(), place.x()), std::asin(std::min(1.0, radius / place.norm()))};
}

/// No corner of the box around it is outside the picture or near its border.
bool is_whole(const CylinderView& view, const RoundBody& cylinder, const RgbdCameraOptions& camera) {
  constexpr double kMargin = 8.0;  // pixels
  for (int i = 0; i < 8; ++i) {
    const double radius = cylinder.foot_radius;
    const Eigen::Vector3d aside((i & 1) != 0 ? radius : -radius, (i & 2) != 0 ? radius : -radius, 0.0);
    const Eigen::Vector3d corner =
        cylinder.foot_in_world + aside + ((i & 4) != 0 ? 1.0 : 0.0) * cylinder.axis;
    const Eigen::Vector3d seen = view.world_from_optical.inverse() * corner;
    if (std::abs(camera.focal_length * seen.x() / seen.z()) > 0.5 * camera.width - kMargin) return false;
    if (std::abs(camera.focal_length * seen.y() / seen.z()) > 0.5 * camera.height - kMargin) return false;
  }
  return true;
}

/// Between the two depths, whole in the picture, and nothing nearer stands in the way of any part of it.
bool is_expected(const CylinderView& view, const RoundBody& cylinder, const CylinderStudy& study) {
  constexpr double kMargin = 0.03;  // rad
  const Eigen::Isometry3d optical_from_world = view.world_from_optical.inverse();
  const double depth = (optical_from_world * (cylinder.foot_in_world + 0.5 * cylinder.axis)).z();
  if (depth < study.nearest || depth > study.farthest || !is_whole(view, cylinder, study.camera))
    return false;
  const Sight sight = sight_of(cylinder.foot_in_world.head<2>(), cylinder.foot_radius);
  const auto hides = [&](const Eigen::Vector2d& place, double radius) {
    const Sight other = sight_of(place, radius);
    return other.distance < sight.distance &&
           std::abs(other.bearing - sight.bearing) < other.half_width + sight.half_width + kMargin;
  };
  for (const RoundBody& body : view.scene.bodies) {
    const Eigen::Vector2d middle = (body.foot_in_world + 0.5 * body.axis).head<2>();
    const bool is_itself = body.foot_in_world == cylinder.foot_in_world;
    const double reach = std::max({body.foot_radius, body.top_radius, 0.5 * body.axis.head<2>().norm()});
    if (!is_itself && hides(middle, reach)) return false;
  }
  for (const Panel& panel : view.scene.panels) {
    const double size = (panel.along + panel.down).head<2>().norm();
    if (size > 1.0) continue;  // floor and wall
    const Eigen::Vector2d middle = (panel.corner_in_world + 0.5 * (panel.along + panel.down)).head<2>();
    if (hides(middle, 0.5 * size)) return false;
  }
  return true;
}

const char* label_of(const Rgb& colour) {
  for (const char* label : kLabels) {
    if (paint(label).red == colour.red && paint(label).blue == colour.blue) return label;
  }
  return kUnknownColour;
}

/// Counts and errors of one view after the other.
class Tally {
 public:
  explicit Tally(const CylinderStudy& study) : study_(study) {}

  void add(const CylinderView& view, const Findings& findings) {
    std::vector<bool> used(findings.found.size(), false);
    for (const RoundBody& cylinder : view.cylinders) {
      const bool expected = is_expected(view, cylinder, study_);
      result_.expected += expected ? 1 : 0;
      const Eigen::Vector3d truth =
          view.world_from_optical.inverse() * (cylinder.foot_in_world + 0.5 * cylinder.axis);
      for (std::size_t i = 0; i < used.size(); ++i) {
        const Finding& finding = findings.found[i];
        // Of what is hidden or cut off in part, the height is not known.
        const Eigen::Vector3d error = finding.position - truth;
        if (used[i] || error.norm() > kMatchDistance) continue;
        used[i] = true;
        result_.true_ones += is_judged(finding) ? 1 : 0;
        result_.found += expected ? 1 : 0;
        if (expected) add(finding, error, cylinder);
        break;
      }
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
      result_.false_ones += !used[i] && is_judged(findings.found[i]) ? 1 : 0;
    }
  }

  CylinderStudyResult result(double milliseconds) const {
    CylinderStudyResult result = result_;
    const auto count = static_cast<double>(std::max(result.found, 1));
    result.center_rmse = std::sqrt(result.center_rmse / count);
    result.radius_rmse = std::sqrt(result.radius_rmse / count);
    result.nees_mean /= count;
    constexpr double kTail = 0.025;
    result.nees_low = chi_square_quantile(kTail, 3.0 * count) / count;
    result.nees_high = chi_square_quantile(1.0 - kTail, 3.0 * count) / count;
    result.milliseconds = milliseconds / study_.views;
    return result;
  }

 private:
  bool is_judged(const Finding& finding) const {
    return finding.position.z() >= study_.nearest && finding.position.z() <= study_.farthest;
  }

  void add(const Finding& finding, const Eigen::Vector3d& error, const RoundBody& cylinder) {
    const double radius_error = finding.signature.radius - cylinder.foot_radius;
    result_.center_rmse += error.squaredNorm();
    result_.radius_rmse += radius_error * radius_error;
    result_.nees_mean += error.dot(finding.covariance.ldlt().solve(error));
    result_.wrong_labels += finding.signature.label == label_of(cylinder.colour) ? 0 : 1;
  }

  const CylinderStudy& study_;
  CylinderStudyResult result_;
};

/// By a Kinect of its own: none is calibrated exactly, and its windows compare more or less well.
RgbdPicture take_picture(const CylinderView& view, RgbdCameraOptions camera, std::uint64_t seed) {
  constexpr double kDepthScaleSigma = 0.002;
  constexpr double kCentreSigma = 1.0;  // pixels
  RandomStream random(seed, 2);
  camera.depth_scale = 1.0 + kDepthScaleSigma * random.normal();
  camera.half_window += static_cast<int>(random.index(3)) - 1;
  RgbdImage image = render(view.scene, view.world_from_optical, camera);
  add_kinect_errors(camera, &random, &image);
  RgbdPicture picture = to_picture(image, camera);
  picture.camera.cx += kCentreSigma * random.normal();
  picture.camera.cy += kCentreSigma * random.normal();
  return picture;
}

}  // namespace

CylinderView random_cylinder_view(std::uint64_t seed) {
  RandomStream random(seed, 1);
  CylinderView view;
  view.scene.brightness = random.uniform(0.5, 1.2);
  add_room(&random, &view.scene);
  Stage stage(&random, &view);
  const std::size_t cylinders = 2 + random.index(3);
  for (std::size_t i = 0; i < cylinders; ++i) stage.add_cylinder();
  stage.add_box();
  if (random.chance(0.5)) stage.add_box();
  if (random.chance(0.5)) stage.add_bowl();
  if (random.chance(0.3)) stage.add_legs();
  if (random.chance(0.5)) stage.add_roll();
  // The camera looks ahead and a little down from where a small robot carries it.
  const double tilt = random.uniform(0.0, 0.35);
  view.world_from_optical.translation().z() = random.uniform(0.25, 0.6);
  Eigen::Matrix3d base_from_level;
  base_from_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  view.world_from_optical.linear() =
      base_from_level * Eigen::AngleAxisd(-tilt, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return view;
}

RgbdPicture first_picture(const CylinderStudy& study) {
  return take_picture(random_cylinder_view(study.first_seed), study.camera, study.first_seed);
}

CylinderStudyResult run_study(const CylinderStudy& study) {
  const KinectCylinderDetector detector(study.detector, study.palette);
  Tally tally(study);
  double milliseconds = 0.0;
  for (int i = 0; i < study.views; ++i) {
    const std::uint64_t seed = study.first_seed + i;
    const CylinderView view = random_cylinder_view(seed);
    const RgbdPicture picture = take_picture(view, study.camera, seed);
    const double start = thread_seconds();
    const Findings findings = detector.detect(picture);
    milliseconds += 1e3 * (thread_seconds() - start);
    tally.add(view, findings);
    if (study.on_progress) study.on_progress(static_cast<double>(i + 1) / study.views);
  }
  return tally.result(milliseconds);
}

std::string to_table(const CylinderStudyResult& result) {
  char text[1024];
  std::snprintf(text, sizeof(text),
                "recall              %.4f   (%d of %d)\n"
                "precision           %.4f   (%d false)\n"
                "labels wrong        %d\n"
                "centre RMSE         %.4f m\n"
                "radius RMSE         %.4f m\n"
                "NEES, mean          %.2f     (95 %% bounds %.2f to %.2f)\n"
                "time per picture    %.1f ms\n",
                result.recall(), result.found, result.expected, result.precision(), result.false_ones,
                result.wrong_labels, result.center_rmse, result.radius_rmse, result.nees_mean,
                result.nees_low, result.nees_high, result.milliseconds);
  return text;
}

}  // namespace kinect_ekf_slam
