#pragma once

#include <string>
#include <vector>

namespace kinect_ekf_slam {

/// Letters that must be put in, taken out or replaced to make one word of the other: the Levenshtein
/// distance.
int edit_distance(const std::string& a, const std::string& b);

/// Which of the `known` keys (group/name) the writer of `key` may have meant: one of the same name in another
/// group, or the one whose spelling is nearest; empty: none is near.
std::string similar_key(const std::string& key, const std::vector<std::string>& known);

}  // namespace kinect_ekf_slam
