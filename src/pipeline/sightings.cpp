#include "kinect_ekf_slam/pipeline/sightings.h"

#include "kinect_ekf_slam/pipeline/is_covariance.h"

namespace kinect_ekf_slam {
namespace {

/// Finite, and no farther than any sensor sees: the digits of a larger number drown those of the map.
bool is_place(const Eigen::Vector3d& point_in_base) {
  constexpr double kFarthest = 1e6;  // m
  return (point_in_base.array().abs() <= kFarthest).all();
}

}  // namespace

template <class Space>
Sightings<Space>::Sightings(const std::vector<Detection>& detections, const SensorOptions& options)
    : refusals(detections.size(), Verdict::kInvalid) {
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (!is_place(detections[i].position_in_base)) continue;
    if (!in_range(detections[i], options)) {
      refusals[i] = Verdict::kOutOfRange;
    } else if (static_cast<int>(observations.size()) >= options.max_detections) {
      refusals[i] = Verdict::kTooMany;
    } else {
      const Detection seen = with_noise(detections[i], options);
      Observation<Space> observation{Space::from_3d(seen.position_in_base),
                                     Space::from_3d(seen.covariance_in_base), options.correlation_time,
                                     seen.signature, static_cast<int>(i)};
      if (!is_covariance(observation.covariance)) continue;
      detection_of_observation.push_back(i);
      observations.push_back(std::move(observation));
    }
  }
}

template struct Sightings<Planar>;
template struct Sightings<Spatial>;

}  // namespace kinect_ekf_slam
