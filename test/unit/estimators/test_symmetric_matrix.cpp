#include "kinect_ekf_slam/estimators/symmetric_matrix.h"

#include <gtest/gtest.h>

#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;

Eigen::MatrixXd symmetric(int size) {
  const Eigen::MatrixXd any = Eigen::MatrixXd::Random(size, size);
  return any + any.transpose();
}

SymmetricMatrix stored(const Eigen::MatrixXd& dense, int first_rows) {
  SymmetricMatrix matrix(first_rows);
  matrix.set_dense(dense);
  return matrix;
}

// Sizes in the first panel, at both sides of the panels' ends, and in the midst of one.
constexpr int kSizes[] = {3, 5, 49, 51, 53, 99, 101, 160};

TEST(SymmetricMatrix, AddsAProduct) {
  for (const int size : kSizes) {
    for (const int rank : {1, 3, 16, SymmetricMatrix::kMostColumns + 2}) {
      const Eigen::MatrixXd before = symmetric(size);
      const Eigen::MatrixXd factor = Eigen::MatrixXd::Random(size, rank);
      SymmetricMatrix matrix = stored(before, 3);
      matrix.add_product(-0.5, factor, factor);
      EXPECT_TRUE(MatrixNear(matrix.dense(), before - 0.5 * factor * factor.transpose(), 1e-12))
          << size << " of rank " << rank;
    }
  }
}

TEST(SymmetricMatrix, KeepsWhatItHasWhenItGrowsAndAddsZeros) {
  for (const int size : kSizes) {
    const Eigen::MatrixXd before = symmetric(size);
    SymmetricMatrix matrix = stored(before, 3);
    const Eigen::MatrixXd factor = Eigen::MatrixXd::Random(size, 16);
    matrix.add_product(1.0, factor, factor);  // may leave something beyond the last row
    matrix.resize(size + 60);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(size + 60, size + 60);
    expected.topLeftCorner(size, size) = before + factor * factor.transpose();
    EXPECT_TRUE(MatrixNear(matrix.dense(), expected, 1e-12)) << size;
  }
}

TEST(SymmetricMatrix, GivesBlocksAndColumns) {
  const Eigen::MatrixXd dense = symmetric(160);
  const SymmetricMatrix matrix = stored(dense, 6);
  for (const int row : {6, 51, 54, 102, 156}) {
    for (const int col : {6, 51, 99, 156}) {
      EXPECT_EQ((matrix.block<3, 3>(row, col)), (dense.block<3, 3>(row, col))) << row << ", " << col;
    }
    Eigen::MatrixXd columns(160, 3);
    matrix.copy_columns(row, columns);
    EXPECT_EQ(columns, dense.middleCols(row, 3)) << row;
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
