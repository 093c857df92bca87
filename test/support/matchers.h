#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <functional>

#include "kinect_ekf_slam/core/se2.h"
#include "kinect_ekf_slam/core/se3.h"

namespace kinect_ekf_slam::testing {

/// Every entry within `tolerance`; prints both matrices when not.
::testing::AssertionResult MatrixNear(const Eigen::Ref<const Eigen::MatrixXd>& left,
                                      const Eigen::Ref<const Eigen::MatrixXd>& right, double tolerance);

/// The angle between two headings, whichever is the larger, at most `tolerance`.
::testing::AssertionResult AngleNear(double left, double right, double tolerance);

::testing::AssertionResult PoseNear(const Se2& left, const Se2& right, double tolerance);
::testing::AssertionResult PoseNear(const Se3& left, const Se3& right, double tolerance);

/// Symmetric to the last bit, and no eigenvalue below -`tolerance` times the largest.
::testing::AssertionResult IsCovariance(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                                        double tolerance = 1e-12);

/// Central differences of `function` (vector to vector) at `x`, for the columns of a Jacobian.
Eigen::MatrixXd numerical_jacobian(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
                                   const Eigen::VectorXd& x, double step = 1e-6);

}  // namespace kinect_ekf_slam::testing
