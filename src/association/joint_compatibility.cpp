#include "kinect_ekf_slam/association/joint_compatibility.h"

#include <algorithm>
#include <utility>

namespace kinect_ekf_slam {

template <class Space>
class JointCompatibility<Space>::Search {
 public:
  Search(const JointCompatibility& method, const std::vector<Observation<Space>>& observations,
         const PredictedMap<Space>& map, const std::vector<GatedPair>& pairs)
      : method_(method),
        observations_(observations),
        joint_(map),
        options_(observations.size()),
        landmark_taken_(static_cast<std::size_t>(map.size()), false),
        present_(observations.size(), nullptr) {
    for (const GatedPair& pair : pairs) options_[pair.observation].push_back(&pair);
    for (std::vector<const GatedPair*>& options : options_) {
      std::sort(options.begin(), options.end(), [](const GatedPair* left, const GatedPair* right) {
        return left->squared_distance < right->squared_distance;
      });
    }
  }

  /// The pair that each observation takes part in, null: none.
  const std::vector<const GatedPair*>& best() {
    best_ = present_;
    branch(0, 0.0);
    return best_;
  }

 private:
  void branch(std::size_t observation, double attributes) {
    const int left = static_cast<int>(observations_.size() - observation);
    if (joint_.size() + left < best_size_) return;  // the bound: even with all that are left it would lose
    if (left == 0) {
      const double distance = joint_.squared_distance() + attributes;
      if (joint_.size() > best_size_ || distance < best_distance_) {
        best_ = present_;
        best_size_ = joint_.size();
        best_distance_ = distance;
      }
      return;
    }
    for (const GatedPair* pair : options_[observation]) {
      if (work_ >= method_.most_work_ && best_size_ >= 0) return;
      if (landmark_taken_[pair->landmark]) continue;
      ++work_;
      const auto increment = joint_.push(observations_[observation], pair->landmark);
      if (!increment) continue;
      if (joint_.squared_distance() + attributes < method_.gates_.joint(joint_.size())) {
        landmark_taken_[pair->landmark] = true;
        present_[observation] = pair;
        branch(observation + 1, attributes);
        present_[observation] = nullptr;
        landmark_taken_[pair->landmark] = false;
      }
      joint_.pop();
    }
    branch(observation + 1, attributes);  // nobody's
  }

  const JointCompatibility& method_;
  const std::vector<Observation<Space>>& observations_;
  JointInnovation<Space> joint_;
  std::vector<std::vector<const GatedPair*>> options_;  ///< by observation, likely ones first
  std::vector<bool> landmark_taken_;
  std::vector<const GatedPair*> present_;
  std::vector<const GatedPair*> best_;
  int best_size_ = -1;
  double best_distance_ = 0.0;
  int work_ = 0;
};

template <class Space>
std::vector<Assignment> JointCompatibility<Space>::associate(
    const typename Associator<Space>::Observations& observations, const PredictedMap<Space>& map) const {
  GatedPairs<Space> gated = gates_.pair(observations, map);
  Search search(*this, observations, map, gated.pairs);
  const std::vector<const GatedPair*>& best = search.best();
  std::vector<Assignment> assignments = std::move(gated.otherwise);
  for (std::size_t k = 0; k < best.size(); ++k) {
    if (best[k] == nullptr) continue;
    assignments[k] = {Verdict::kMatched, best[k]->landmark, best[k]->squared_distance};
  }
  gates_.refuse_echoes(observations, &assignments);
  return assignments;
}

template class JointCompatibility<Planar>;
template class JointCompatibility<Spatial>;

}  // namespace kinect_ekf_slam
