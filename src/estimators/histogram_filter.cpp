#include "kinect_ekf_slam/estimators/histogram_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace kinect_ekf_slam {
namespace {

double sum_of(const std::vector<double>& values) {
  const bool are_probabilities = std::all_of(
      values.begin(), values.end(), [](double value) { return value >= 0.0 && std::isfinite(value); });
  if (!are_probabilities)
    throw std::invalid_argument("HistogramFilter: a probability is negative or not finite");
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

HistogramFilter::HistogramFilter(std::vector<double> belief) : belief_(std::move(belief)) {
  correct(std::vector<double>(belief_.size(), 1.0));
}

void HistogramFilter::predict(const std::vector<double>& step_probabilities) {
  constexpr double kTolerance = 1e-9;
  if (std::abs(sum_of(step_probabilities) - 1.0) > kTolerance) {
    throw std::invalid_argument("HistogramFilter: the probabilities of the steps do not add up to one");
  }
  std::vector<double> moved(belief_.size(), 0.0);
  for (std::size_t cell = 0; cell < belief_.size(); ++cell) {
    for (std::size_t step = 0; step < step_probabilities.size(); ++step) {
      moved[(cell + step) % belief_.size()] += step_probabilities[step] * belief_[cell];
    }
  }
  belief_ = std::move(moved);
}

double HistogramFilter::correct(const std::vector<double>& likelihood) {
  if (likelihood.size() != belief_.size()) {
    throw std::invalid_argument("HistogramFilter: one likelihood a cell is needed");
  }
  std::vector<double> joint(belief_.size());
  std::transform(belief_.begin(), belief_.end(), likelihood.begin(), joint.begin(), std::multiplies<>());
  const double evidence = sum_of(joint);
  if (!(evidence > 0.0)) throw std::invalid_argument("HistogramFilter: what was measured is impossible");
  for (double& probability : joint) probability /= evidence;
  belief_ = std::move(joint);
  return evidence;
}

}  // namespace kinect_ekf_slam
