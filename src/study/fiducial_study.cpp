#include "kinect_ekf_slam/study/fiducial_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/simulation/scene.h"
#include "kinect_ekf_slam/study/simulated_picture.h"

namespace kinect_ekf_slam {
namespace {

constexpr int kIdentities = 50;  // every dictionary has so many

struct FiducialView {
  Scene scene;
  int identity = 0;
  Eigen::Vector3d center_in_optical = Eigen::Vector3d::Zero();  ///< m
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
};

FiducialView random_view(const FiducialOptions& options, RandomStream* random) {
  FiducialView view;
  view.identity = static_cast<int>(random->index(kIdentities));
  view.world_from_optical.translation().z() = 1.0;
  view.world_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const double distance = random->uniform(0.5, 2.5);
  const double aside = random->uniform(-0.35, 0.35) * distance;
  const double up = random->uniform(-0.2, 0.2) * distance;
  const Eigen::Vector3d center(distance, aside, 1.0 + up);
  const std::vector<std::string> pattern = fiducial_pattern(options.dictionary, view.identity);
  const auto modules = static_cast<double>(pattern.size());
  const double slant = radians(random->uniform(-60.0, 60.0));
  const double facing = std::atan2(-aside, -distance) + slant;
  const double size = options.side * (modules + 2.0) / modules;
  view.scene.panels.push_back(upright_panel(center, facing, size, printed(pattern)));
  view.scene.panels.push_back({{4.0, 5.0, 3.0}, {0.0, -10.0, 0.0}, {0.0, 0.0, -3.0}, blotches(600, 180, 1)});
  view.scene.brightness = random->uniform(0.5, 1.1);
  view.center_in_optical = view.world_from_optical.inverse() * center;
  return view;
}

}  // namespace

FiducialStudyResult run_study(const FiducialStudy& study) {
  const FiducialDetector detector(study.detector);
  RgbdCameraOptions camera;
  camera.samples = 3;
  FiducialStudyResult result;
  for (int i = 0; i < study.views; ++i) {
    RandomStream random(study.first_seed + i, 0);
    const FiducialView view = random_view(study.detector, &random);
    RgbdImage image = render(view.scene, view.world_from_optical, camera);
    add_kinect_errors(camera, &random, &image);
    const Findings findings = detector.detect(to_picture(image, camera));
    ++result.views;
    for (const Finding& finding : findings.found) {
      if (finding.signature.source_id != view.identity) {
        ++result.wrong_identities;
        continue;
      }
      const double relative =
          (finding.position - view.center_in_optical).norm() / view.center_in_optical.norm();
      ++result.found;
      result.within_one_percent += relative <= 0.01 ? 1 : 0;
      result.relative_error_rms += relative * relative;
      result.relative_error_worst = std::max(result.relative_error_worst, relative);
    }
    if (study.on_progress) study.on_progress(static_cast<double>(i + 1) / study.views);
  }
  result.relative_error_rms = std::sqrt(result.relative_error_rms / std::max(result.found, 1));
  return result;
}

std::string to_table(const FiducialStudyResult& result) {
  char text[512];
  std::snprintf(text, sizeof(text),
                "found               %d of %d\n"
                "wrong identities    %d\n"
                "within 1 %%          %d of %d   (error of the position over the distance)\n"
                "relative error      RMS %.4f, worst %.4f\n",
                result.found, result.views, result.wrong_identities, result.within_one_percent, result.found,
                result.relative_error_rms, result.relative_error_worst);
  return text;
}

}  // namespace kinect_ekf_slam
