#include "kinect_ekf_slam/fusion/path_spline.h"

#include <Eigen/SparseLU>
#include <algorithm>
#include <stdexcept>
#include <utility>

namespace kinect_ekf_slam {
namespace {

constexpr int kCubic = 3;

/// Solves matrix * x = right; the matrix is a spline's, a band around the diagonal, and regular.
Eigen::MatrixXd solve(const Eigen::SparseMatrix<double>& matrix, const Eigen::MatrixXd& right) {
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
  lu.compute(matrix);
  return lu.solve(right);
}

}  // namespace

template <int Dim>
PathSpline<Dim>::PathSpline(std::vector<TimeNs> stamps, const std::vector<Point>& points)
    : stamps_(std::move(stamps)), degree_(std::min(kCubic, static_cast<int>(points.size()) - 1)) {
  if (points.empty() || points.size() != stamps_.size()) {
    throw std::invalid_argument("path spline: " + std::to_string(points.size()) + " points and " +
                                std::to_string(stamps_.size()) + " times given, as many of each are needed");
  }
  for (std::size_t i = 1; i < stamps_.size(); ++i) {
    if (stamps_[i] <= stamps_[i - 1]) throw std::invalid_argument("path spline: the times do not ascend");
  }
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Array<double, 1, Eigen::Dynamic> parameters(count);
  for (Eigen::Index i = 0; i < count; ++i) parameters(i) = parameter(stamps_[static_cast<std::size_t>(i)]);
  if (degree_ > 0) Eigen::KnotAveraging(parameters, degree_, knots_);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::SparseVector<double> N = basis(stamps_[static_cast<std::size_t>(k)]);
    for (Eigen::SparseVector<double>::InnerIterator i(N); i; ++i) {
      entries.emplace_back(static_cast<int>(k), static_cast<int>(i.index()), i.value());
    }
  }
  collocation_.resize(count, count);
  collocation_.setFromTriplets(entries.begin(), entries.end());
  Eigen::MatrixXd rows(count, Dim);
  for (Eigen::Index i = 0; i < count; ++i) rows.row(i) = points[static_cast<std::size_t>(i)].transpose();
  control_points_ = solve(collocation_, rows).transpose();
}

template <int Dim>
double PathSpline<Dim>::parameter(TimeNs stamp) const {
  return start() == end() ? 0.0 : to_seconds(stamp - start()) / to_seconds(end() - start());
}

/// N_i(u): de Boor's recursion. Eigen takes the last knot for the end of the last span, as it must be.
template <int Dim>
Eigen::SparseVector<double> PathSpline<Dim>::basis(TimeNs stamp) const {
  using Curve = Eigen::Spline<double, Dim>;
  Eigen::SparseVector<double> basis(static_cast<Eigen::Index>(stamps_.size()));
  if (degree_ == 0) {
    basis.insert(0) = 1.0;
    return basis;
  }
  const double u = std::clamp(parameter(stamp), 0.0, 1.0);
  const auto values = Curve::BasisFunctions(u, degree_, knots_);
  const Eigen::Index first = Curve::Span(u, degree_, knots_) - degree_;
  for (Eigen::Index i = 0; i <= degree_; ++i) basis.insert(first + i) = values(i);
  return basis;
}

template <int Dim>
typename PathSpline<Dim>::Point PathSpline<Dim>::position(TimeNs stamp) const {
  return control_points_ * basis(stamp);
}

template <int Dim>
Eigen::MatrixXd PathSpline<Dim>::weights(const std::vector<TimeNs>& stamps) const {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(collocation_.rows(), static_cast<Eigen::Index>(stamps.size()));
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    rows.col(static_cast<Eigen::Index>(k)) = Eigen::VectorXd(basis(stamps[k]));
  }
  return solve(collocation_.transpose(), rows).transpose();
}

template <int Dim>
typename PathSpline<Dim>::Matrix PathSpline<Dim>::covariance(TimeNs stamp,
                                                             const std::vector<Matrix>& covariances) const {
  const Eigen::MatrixXd w = weights({stamp});
  Matrix covariance = Matrix::Zero();
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    const double weight = w(0, static_cast<Eigen::Index>(i));
    covariance += weight * weight * covariances[i];
  }
  return covariance;
}

template class PathSpline<2>;
template class PathSpline<3>;

}  // namespace kinect_ekf_slam
