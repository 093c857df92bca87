#include "kinect_ekf_slam/estimators/wide_product.h"

#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace kinect_ekf_slam {

#if defined(__x86_64__) && defined(__GNUC__)

bool has_wide_product() {
  static const bool has = [] {
    const char* wanted = std::getenv("KINECT_EKF_SLAM_WIDE");
    return (wanted == nullptr || std::strcmp(wanted, "0") != 0) && __builtin_cpu_supports("avx2") &&
           __builtin_cpu_supports("fma");
  }();
  return has;
}

// Eight rows of four columns stay in registers while the depth passes: six loads for eight multiply-and-adds,
// of which a core does two at a time. Eigen's product would do the same if the package were built for this
// processor.
__attribute__((target("avx2,fma"))) void add_wide_product(double* target, int columns, const double* left,
                                                          const double* right, int depth) {
  using Four = double __attribute__((vector_size(32), aligned(8), may_alias));
  constexpr std::ptrdiff_t kFours = kWideRows / 4;  // a column
  constexpr int kAhead = 8;  // columns that are fetched early: memory is slower than this
  for (int col = 0; col < columns; col += kWideColumns) {
    const double* factors = right + static_cast<std::ptrdiff_t>(col) * depth;
    auto* corner = reinterpret_cast<Four*>(target + static_cast<std::ptrdiff_t>(col) * kWideRows);
    auto* rows = reinterpret_cast<const Four*>(left);
    for (int row = 0; row < kFours; row += 2, corner += 2, rows += 2) {
      for (int j = 0; j < kWideColumns; ++j) __builtin_prefetch(corner + (j + kAhead) * kFours, 1);
      Four sum[kWideColumns][2];
      for (int j = 0; j < kWideColumns; ++j) {
        for (int i = 0; i < 2; ++i) sum[j][i] = corner[j * kFours + i];
      }
      for (int k = 0; k < depth; ++k) {
        for (int j = 0; j < kWideColumns; ++j) {
          for (int i = 0; i < 2; ++i) sum[j][i] += rows[k * kFours + i] * factors[j * depth + k];
        }
      }
      for (int j = 0; j < kWideColumns; ++j) {
        for (int i = 0; i < 2; ++i) corner[j * kFours + i] = sum[j][i];
      }
    }
  }
}
#else
bool has_wide_product() { return false; }
void add_wide_product(double* /*target*/, int /*columns*/, const double* /*left*/, const double* /*right*/,
                      int /*depth*/) {}
#endif

}  // namespace kinect_ekf_slam
