#pragma once

namespace kinect_ekf_slam {

/// Whether this processor has the vectors of four doubles, and the multiply-and-add, that add_wide_product()
/// needs. The package itself is built for any processor of its architecture. Also false where the environment
/// has KINECT_EKF_SLAM_WIDE=0, to compare.
bool has_wide_product();

constexpr int kWideRows = 48;    ///< of the target and of `left`
constexpr int kWideColumns = 4;  ///< of the target, or a multiple
/// target += left * right. `target` is kWideRows x `columns`, `left` kWideRows x `depth`, `right` `depth` x
/// `columns`; all by columns, one after the other without a gap.
void add_wide_product(double* target, int columns, const double* left, const double* right, int depth);

}  // namespace kinect_ekf_slam
