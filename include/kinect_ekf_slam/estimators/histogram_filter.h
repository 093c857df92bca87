#pragma once

#include <vector>

namespace kinect_ekf_slam {

/// Markov localisation on a ring of cells: the belief is one probability a cell, any shape of it is allowed.
class HistogramFilter {
 public:
  /// Throws std::invalid_argument unless `belief` consists of probabilities whose sum is positive; scales
  /// them to the sum one.
  explicit HistogramFilter(std::vector<double> belief);

  /// Moves on by i cells with probability `step_probabilities[i]`, round the ring. Throws
  /// std::invalid_argument unless those are probabilities whose sum is one to 1e-9.
  void predict(const std::vector<double>& step_probabilities);

  /// Bayes' rule: `likelihood[i]` is the probability of what was measured, were the robot in cell i. Returns
  /// the probability of the measurement. Throws std::invalid_argument when it is zero, or the sizes differ.
  double correct(const std::vector<double>& likelihood);

  const std::vector<double>& belief() const { return belief_; }

 private:
  std::vector<double> belief_;
};

}  // namespace kinect_ekf_slam
