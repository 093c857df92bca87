#include "kinect_ekf_slam/estimators/particles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kinect_ekf_slam {

std::vector<double> normalized_weights(const std::vector<double>& log_weights) {
  const double largest = *std::max_element(log_weights.begin(), log_weights.end());
  std::vector<double> weights(log_weights.size(), 1.0);
  if (std::isfinite(largest)) {
    std::transform(log_weights.begin(), log_weights.end(), weights.begin(),
                   [&](double log_weight) { return std::exp(log_weight - largest); });
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

double effective_sample_size(const std::vector<double>& weights) {
  return 1.0 / std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
}

std::vector<std::size_t> low_variance_resample(const std::vector<double>& weights, std::size_t count,
                                               double random) {
  std::vector<std::size_t> chosen;
  chosen.reserve(count);
  double reached = 0.0;  // sum of the weights before `index`
  std::size_t index = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double pointer = (static_cast<double>(i) + random) / static_cast<double>(count);
    while (index + 1 < weights.size() && reached + weights[index] <= pointer) reached += weights[index++];
    chosen.push_back(index);
  }
  return chosen;
}

Eigen::MatrixXd standardized_draws(int dimension, int count, RandomStream* random) {
  Eigen::MatrixXd white = Eigen::MatrixXd::NullaryExpr(dimension, count, [&] { return random->normal(); });
  white.colwise() -= white.rowwise().mean().eval();
  if (count <= dimension) return white;
  const Eigen::MatrixXd covariance = white * white.transpose() / count;
  covariance.llt().matrixL().solveInPlace(white);
  return white;
}

}  // namespace kinect_ekf_slam
