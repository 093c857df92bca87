#include "kinect_ekf_slam/estimators/wide_product.h"

#include <gtest/gtest.h>

#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

TEST(WideProduct, IsTheProduct) {
  if (!has_wide_product()) GTEST_SKIP() << "this processor has no vectors of four";
  for (const int depth : {1, 2, 16, 33}) {
    for (const int columns : {4, 8, 60}) {
      Eigen::MatrixXd target = Eigen::MatrixXd::Random(kWideRows, columns);
      const Eigen::MatrixXd left = Eigen::MatrixXd::Random(kWideRows, depth);
      const Eigen::MatrixXd right = Eigen::MatrixXd::Random(depth, columns);
      const Eigen::MatrixXd expected = target + left * right;
      add_wide_product(target.data(), columns, left.data(), right.data(), depth);
      EXPECT_TRUE(testing::MatrixNear(target, expected, 1e-13)) << depth << " x " << columns;
    }
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
