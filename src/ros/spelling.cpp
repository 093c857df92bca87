#include "kinect_ekf_slam/ros/spelling.h"

#include <algorithm>
#include <numeric>

namespace kinect_ekf_slam {
namespace {

constexpr std::size_t kLettersPerMistake = 4;  // one in so many may be wrong

std::string name_of(const std::string& key) { return key.substr(key.find('/') + 1); }

}  // namespace

int edit_distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);  // of the table over prefixes of a and b
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

std::string similar_key(const std::string& key, const std::vector<std::string>& known) {
  const int most = static_cast<int>(key.size() / kLettersPerMistake);
  std::string nearest;
  int least = 0;
  for (const std::string& candidate : known) {
    const int distance = edit_distance(key, candidate);
    const bool is_near = distance <= most || name_of(candidate) == name_of(key);
    if (is_near && (nearest.empty() || distance < least)) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace kinect_ekf_slam
