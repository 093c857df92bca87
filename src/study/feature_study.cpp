#include "kinect_ekf_slam/study/feature_study.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kinect_ekf_slam/simulation/simulator.h"
#include "kinect_ekf_slam/study/simulated_picture.h"
#include "kinect_ekf_slam/study/text.h"
#include "kinect_ekf_slam/study/thread_time.h"

namespace kinect_ekf_slam {
namespace {

constexpr double kElsewhere = 0.15;  // m

/// Compares each sighting with the first one of the same number.
class Tally {
 public:
  void add(const Findings& findings, const Eigen::Isometry3d& world_from_optical,
           FeatureStudyResult* result) {
    for (const Finding& finding : findings.found) {
      const Eigen::Vector3d place = world_from_optical * finding.position;
      const auto [first, is_new] = first_in_world_.emplace(finding.signature.source_id, place);
      ++result->sightings;
      if (is_new) continue;
      const double distance = (place - first->second).norm();
      ++result->again;
      result->elsewhere += distance > kElsewhere ? 1 : 0;
      result->difference_rms += distance * distance;
    }
    result->tracks = static_cast<int>(first_in_world_.size());
  }

 private:
  std::map<int, Eigen::Vector3d> first_in_world_;
};

}  // namespace

FeatureStudyResult run_study(const FeatureStudy& study) {
  Simulator simulator(study.world, study.seed);
  SimulatedCamera camera(study.world, study.seed);
  FeatureDetector detector(study.detector);
  Tally tally;
  FeatureStudyResult result;
  while (result.pictures < study.pictures && !simulator.finished()) {
    const Sample sample = simulator.next();
    if (!sample.takes_picture) continue;
    result.last_picture = camera.take(sample.world_from_base);
    const double start = thread_seconds();
    result.last_findings = detector.detect(result.last_picture);
    result.milliseconds += 1e3 * (thread_seconds() - start);
    tally.add(result.last_findings, sample.world_from_base * study.world.sensor.base_from_optical, &result);
    ++result.pictures;
    if (study.on_progress) study.on_progress(static_cast<double>(result.pictures) / study.pictures);
  }
  result.milliseconds /= std::max(result.pictures, 1);
  result.difference_rms = std::sqrt(result.difference_rms / std::max(result.again, 1));
  return result;
}

std::string to_table(const FeatureStudyResult& result) {
  const double pictures = std::max(result.pictures, 1);
  return format("pictures            %d\n", result.pictures) +
         format("reported            %.1f a picture\n", result.sightings / pictures) +
         format("tracks              %d, each reported %.1f times\n", result.tracks,
                static_cast<double>(result.sightings) / std::max(result.tracks, 1)) +
         format(
             "same place          RMS %.4f m from where the track was first; %d of %d more than %.2f m off\n",
             result.difference_rms, result.elsewhere, result.again, kElsewhere) +
         format("time per picture    %.1f ms\n", result.milliseconds);
}

}  // namespace kinect_ekf_slam
