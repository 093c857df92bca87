#include "kinect_ekf_slam/association/gated_pairs.h"

#include <algorithm>
#include <cmath>

#include "kinect_ekf_slam/association/gate.h"
#include "kinect_ekf_slam/core/chi_square.h"
#include "kinect_ekf_slam/core/position.h"

namespace kinect_ekf_slam {
namespace {

constexpr int kMostJoint = 64;  // sightings; beyond, the quantile of so many is a little too narrow

double squared(double value) { return value * value; }

/// Cheap, and never wrong: the largest eigenvalue of S is at most its trace.
bool is_beyond(double squared_distance, double trace, const AssociationReach& reach) {
  return squared_distance > squared(reach.distance) && squared_distance > reach.squared_mahalanobis * trace;
}

double descriptor_distance(const std::vector<float>& seen, const std::vector<float>& mapped) {
  if (seen.empty() || seen.size() != mapped.size()) return 0.0;
  return (Eigen::Map<const Eigen::VectorXf>(seen.data(), static_cast<Eigen::Index>(seen.size())) -
          Eigen::Map<const Eigen::VectorXf>(mapped.data(), static_cast<Eigen::Index>(mapped.size())))
      .squaredNorm();
}

}  // namespace

double attribute_distance(const Signature& seen, const LandmarkInfo& mapped,
                          const AssociationOptions& options) {
  double distance = 0.0;
  const std::string label = mapped.label();
  if (!seen.label.empty() && !label.empty() && seen.label != label) {
    distance += 2.0 * std::log((1.0 - options.label_error) / options.label_error);
  }
  if (options.radius_sigma > 0.0 && seen.radius > 0.0 && mapped.radius_observations > 0) {
    const double variance = squared(options.radius_sigma) * (1.0 + 1.0 / mapped.radius_observations);
    distance += squared(seen.radius - mapped.radius) / variance;
  }
  if (options.descriptor_sigma > 0.0) {
    distance += descriptor_distance(seen.descriptor, mapped.descriptor) / squared(options.descriptor_sigma);
  }
  return distance;
}

template <class Space>
Gates<Space>::Gates(const AssociationOptions& options)
    : options_(options),
      gate_(chi_square_quantile(options.gate_probability, Space::kPointDim)),
      new_landmark_gate_(chi_square_quantile(options.new_landmark_probability, Space::kPointDim)) {
  for (int count = 0; count <= kMostJoint; ++count) {
    joint_gates_.push_back(
        count == 0 ? 0.0 : chi_square_quantile(options.gate_probability, Space::kPointDim * count));
  }
}

template <class Space>
double Gates<Space>::joint(int count) const {
  return joint_gates_[static_cast<std::size_t>(std::min(count, kMostJoint))];
}

template <class Space>
AssociationReach Gates<Space>::reach() const {
  return {std::max(gate_, new_landmark_gate_), options_.new_landmark_distance};
}

template <class Space>
GatedPairs<Space> Gates<Space>::pair(const std::vector<Observation<Space>>& observations,
                                     const PredictedMap<Space>& map) const {
  GatedPairs<Space> gated;
  gated.otherwise.resize(observations.size());
  for (Assignment& assignment : gated.otherwise) {
    assignment.verdict = Verdict::kCreated;  // until a landmark objects
  }
  for (int landmark = 0; landmark < map.size(); ++landmark) {
    if (is_beacon(map.info(landmark).id)) continue;
    const typename Space::Point expected = map.point_in_base(landmark);
    const typename Space::PointMatrix covariance = map.covariance(landmark);
    for (std::size_t k = 0; k < observations.size(); ++k) {
      const typename Space::Point innovation = observations[k].position_in_base - expected;
      const typename Space::PointMatrix S = covariance + observations[k].covariance;
      if (is_beyond(innovation.squaredNorm(), S.trace(), reach())) continue;
      const auto distance = squared_mahalanobis<Space::kPointDim>(innovation, S);
      Assignment& assignment = gated.otherwise[k];
      if (!distance) {
        assignment.verdict = Verdict::kSingular;
        continue;
      }
      const bool objects =
          *distance < new_landmark_gate_ || innovation.norm() < options_.new_landmark_distance;
      if (*distance < gate_) {
        const double attributes = attribute_distance(observations[k].signature, map.info(landmark), options_);
        if (*distance + attributes < gate_) gated.pairs.push_back({*distance + attributes, k, landmark});
      }
      if (objects && (assignment.verdict == Verdict::kCreated || (assignment.verdict == Verdict::kAmbiguous &&
                                                                  *distance < assignment.squared_distance))) {
        assignment = {Verdict::kAmbiguous, landmark, *distance};
      } else if (assignment.verdict == Verdict::kCreated && !(assignment.squared_distance <= *distance)) {
        assignment.squared_distance = *distance;
      }
    }
  }
  return gated;
}

template <class Space>
void Gates<Space>::refuse_echoes(const std::vector<Observation<Space>>& observations,
                                 std::vector<Assignment>* assignments) const {
  std::vector<std::size_t> unmapped;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if ((*assignments)[k].verdict == Verdict::kCreated) unmapped.push_back(k);
  }
  std::stable_sort(unmapped.begin(), unmapped.end(), [&](std::size_t left, std::size_t right) {
    return observations[left].position_in_base.norm() < observations[right].position_in_base.norm();
  });
  std::vector<std::size_t> kept;
  for (const std::size_t k : unmapped) {
    const bool is_echo = std::any_of(kept.begin(), kept.end(), [&](std::size_t other) {
      const typename Space::Point difference =
          observations[k].position_in_base - observations[other].position_in_base;
      const auto distance = squared_mahalanobis<Space::kPointDim>(
          difference, observations[k].covariance + observations[other].covariance);
      return !distance || *distance < gate_ || difference.norm() < options_.new_landmark_distance;
    });
    if (is_echo) {
      (*assignments)[k].verdict = Verdict::kDuplicateIdentity;
    } else {
      kept.push_back(k);
    }
  }
}

template class Gates<Planar>;
template class Gates<Spatial>;

}  // namespace kinect_ekf_slam
