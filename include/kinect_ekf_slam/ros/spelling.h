#pragma once

#include <string>
#include <vector>

namespace kinect_ekf_slam {

/// Letters that must be put in, taken out or replaced to make one word of the other: the Levenshtein
/// distance.
int edit_distance(const std::string& a, const std::string& b);

/// Which of the `known` keys (group/name) the writer of `key` may have meant: the nearest by spelling
/// of those that are near or have the same name in another group; empty: there is none.
std::string similar_key(const std::string& key, const std::vector<std::string>& known);

}  // namespace kinect_ekf_slam
