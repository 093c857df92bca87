#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace kinect_ekf_slam {

/// Random numbers of one part of a program. Each part has a stream of its own, so that another setting of one
/// leaves the numbers of the others as they were.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint32_t stream) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U), stream};
    engine_.seed(sequence);
  }

  double normal() { return normal_(engine_); }
  double uniform(double low, double high) { return low + (high - low) * uniform_(engine_); }
  bool chance(double probability) { return uniform_(engine_) < probability; }
  /// 0 to count - 1; count is not zero.
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(engine_() % count); }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

}  // namespace kinect_ekf_slam
