#include "kinect_ekf_slam/estimators/contradictions.h"

#include <algorithm>

namespace kinect_ekf_slam {

std::vector<std::size_t> Contradictions::misplaced(const std::vector<Assignment>& assignments,
                                                   const std::function<int(int)>& observations_of) {
  std::vector<std::size_t> misplaced;
  if (replace_after_ == 0) return misplaced;
  for (const Assignment& assignment : assignments) {
    if (assignment.verdict == Verdict::kMatched) forget(assignment.landmark);
  }
  // A message counts once for a landmark, and not against one that it matched as well.
  const auto is_settled = [&](std::size_t k) {
    for (std::size_t other = 0; other < assignments.size(); ++other) {
      if (assignments[other].landmark != assignments[k].landmark) continue;
      if (assignments[other].verdict == Verdict::kMatched) return true;
      if (assignments[other].verdict == Verdict::kOutsideGate && other < k) return true;
    }
    return false;
  };
  for (std::size_t k = 0; k < assignments.size(); ++k) {
    const auto& [verdict, landmark, squared_distance] = assignments[k];
    if (verdict != Verdict::kOutsideGate || landmark < 0 || is_settled(k)) continue;
    if (++in_a_row_[landmark] < std::max(replace_after_, observations_of(landmark))) continue;
    forget(landmark);
    misplaced.push_back(k);
  }
  return misplaced;
}

}  // namespace kinect_ekf_slam
