#include "kinect_ekf_slam/estimators/contradictions.h"

#include <algorithm>
#include <set>

namespace kinect_ekf_slam {

std::vector<std::size_t> Contradictions::misplaced(const std::vector<Assignment>& assignments,
                                                   const std::function<int(int)>& observations_of) {
  std::vector<std::size_t> misplaced;
  if (replace_after_ == 0) return misplaced;
  std::set<int> settled;  // a message counts once for a landmark, and not against one that it matched as well
  for (const Assignment& assignment : assignments) {
    if (assignment.verdict != Verdict::kMatched) continue;
    settled.insert(assignment.landmark);
    forget(assignment.landmark);
  }
  for (std::size_t k = 0; k < assignments.size(); ++k) {
    const auto& [verdict, landmark, squared_distance] = assignments[k];
    if (verdict != Verdict::kOutsideGate || landmark < 0 || !settled.insert(landmark).second) continue;
    if (++in_a_row_[landmark] < std::max(replace_after_, observations_of(landmark))) continue;
    forget(landmark);
    misplaced.push_back(k);
  }
  return misplaced;
}

}  // namespace kinect_ekf_slam
