#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/estimators/particle_localization.h"
#include "kinect_ekf_slam/pipeline/slam_result.h"

namespace kinect_ekf_slam {

/// Notices that the robot is not where it is thought to be, and looks for it in the map.
template <class Space>
class Relocalizer {
 public:
  Localization state() const { return lost_ ? Localization::kLost : state_; }
  bool is_searching() const { return search_ != nullptr; }

  void start(const LocalizationOptions& options, std::vector<LandmarkEstimate<Space>> map) {
    search_ = std::make_unique<ParticleLocalization<Space>>(options, std::move(map));
    state_ = Localization::kSearching;
    lost_ = false;
  }
  void stop() {
    search_.reset();
    state_ = Localization::kTracking;
    fit_ = 1.0;
    lost_ = false;
  }

  void predict(const MotionStep<Space>& step) {
    if (search_) search_->predict(step);
  }

  /// The pose, when the search has found it; the search is then over.
  std::optional<PoseEstimate<Space>> search(const std::vector<Observation<Space>>& observations) {
    auto found = search_->observe(observations);
    if (!found) return std::nullopt;
    stop();
    state_ = Localization::kFound;
    return found;
  }

  /// Whether what is seen fits the map, and what should be seen is. A landmark that is new fits neither well
  /// nor badly.
  void judge(const UpdateReport& report) {
    constexpr double kMemory = 20.0;     // sightings
    constexpr double kFewestFits = 0.3;  // share; clutter alone leaves more
    constexpr double kEnoughFits = 0.6;
    double fits = -report.provisional;
    double misfits = report.missed;
    for (const Assignment& assignment : report.assignments) {
      if (assignment.verdict == Verdict::kCreated) continue;
      (assignment.verdict == Verdict::kMatched ? fits : misfits) += 1.0;
    }
    const double told = fits + misfits;
    if (told > 0.0) fit_ += (fits / told - fit_) * std::min(1.0, told / kMemory);
    lost_ = fit_ < (lost_ ? kEnoughFits : kFewestFits);
  }
  /// True when most of the last sightings fit no landmark of the map.
  bool is_lost() const { return lost_; }

 private:
  std::unique_ptr<ParticleLocalization<Space>> search_;
  Localization state_ = Localization::kTracking;
  double fit_ = 1.0;  ///< running share of the sightings that fit
  bool lost_ = false;
};

}  // namespace kinect_ekf_slam
