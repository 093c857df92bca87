#pragma once

#include <Eigen/Core>
#include <vector>

namespace kinect_ekf_slam {

/// Memory for matrices that are needed for a moment, again and again: it is kept, and settles at the largest
/// size. Each use ends the last one.
class Scratch {
 public:
  /// Not initialised.
  Eigen::Map<Eigen::MatrixXd> matrix(Eigen::Index rows, Eigen::Index cols) {
    const auto size = static_cast<std::size_t>(rows * cols);
    if (memory_.size() < size) memory_.resize(size);
    return {memory_.data(), rows, cols};
  }
  Eigen::Map<Eigen::VectorXd> vector(Eigen::Index size) {
    matrix(size, 1);
    return {memory_.data(), size};
  }

 private:
  std::vector<double> memory_;
};

}  // namespace kinect_ekf_slam
