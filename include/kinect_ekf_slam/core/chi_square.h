#pragma once

namespace kinect_ekf_slam {

/// P(X <= value) for X chi-square distributed with `dof` > 0 degrees of freedom.
/// (Regularised incomplete gamma function by its series and continued fraction, Abramowitz and Stegun 6.5.)
double chi_square_cdf(double value, double dof);

/// The value that X stays below with `probability` in [0, 1], infinite for 1. Throws std::invalid_argument
/// outside.
double chi_square_quantile(double probability, double dof);

}  // namespace kinect_ekf_slam
