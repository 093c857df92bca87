#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

namespace kinect_ekf_slam {

/// Where the sigma points of the unscented transform lie and how they count. (Julier and Uhlmann; Wan and
/// van der Merwe 2000.) The defaults keep them within a few sigmas whatever the dimension.
struct UnscentedOptions {
  double alpha = 0.5;  ///< spread
  double beta = 2.0;   ///< 2: best for Gaussians
  double kappa = 0.0;
};

/// What a function makes of a Gaussian error.
struct UnscentedTransform {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  /// The slope of the function over the spread of the error, C P^-1 with C the covariance of value and error:
  /// what a Jacobian is to the EKF. (Statistical linearisation.)
  Eigen::MatrixXd slope;
};

/// Sends the sigma points of N(0, P), P = root root^T with `root` lower triangular, through `function`: from
/// an error to a vector. Equations (8.1) to (8.4).
template <class Function>
UnscentedTransform unscented_transform(const Eigen::MatrixXd& root, const UnscentedOptions& options,
                                       const Function& function) {
  const auto dimension = root.rows();
  const auto M = static_cast<double>(dimension);
  const double lambda = options.alpha * options.alpha * (M + options.kappa) - M;
  const double spread = std::sqrt(M + lambda);
  const double mean_weight = lambda / (M + lambda);
  const double covariance_weight = mean_weight + 1.0 - options.alpha * options.alpha + options.beta;
  const double weight = 0.5 / (M + lambda);

  const Eigen::VectorXd centre = function(Eigen::VectorXd::Zero(dimension));
  Eigen::MatrixXd up(centre.size(), dimension);
  Eigen::MatrixXd down(centre.size(), dimension);
  for (Eigen::Index i = 0; i < dimension; ++i) {
    up.col(i) = function(spread * root.col(i));
    down.col(i) = function(-spread * root.col(i));
  }
  UnscentedTransform result;
  result.mean = mean_weight * centre + weight * (up.rowwise().sum() + down.rowwise().sum());
  // C = weight spread (up - down) root^T, and P^-1 = root^-T root^-1.
  result.slope = root.triangularView<Eigen::Lower>().template solve<Eigen::OnTheRight>(
      Eigen::MatrixXd(weight * spread * (up - down)));
  up.colwise() -= result.mean;
  down.colwise() -= result.mean;
  result.covariance = weight * (up * up.transpose() + down * down.transpose()) +
                      covariance_weight * (centre - result.mean) * (centre - result.mean).transpose();
  return result;
}

}  // namespace kinect_ekf_slam
