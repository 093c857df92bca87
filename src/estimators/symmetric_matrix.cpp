#include "kinect_ekf_slam/estimators/symmetric_matrix.h"

#include <algorithm>

namespace kinect_ekf_slam {

void SymmetricMatrix::resize(int size) {
  const int old_size = size_;
  size_ = size;
  for (int i = static_cast<int>(panels_.size()); i < panel_count(); ++i) {
    const int rows = first_row(i + 1) - first_row(i);
    panels_.emplace_back(Eigen::MatrixXd::Zero(rows, first_row(i + 1)));
  }
  for (int i = panel_of(old_size); old_size < size && i < panel_count();
       ++i) {  // what was there may be in the way
    panel(i).bottomRows(std::min(end_row(i) - old_size, rows_of(i))).setZero();
  }
}

Eigen::MatrixXd SymmetricMatrix::dense() const {
  Eigen::MatrixXd matrix(size_, size_);
  for (int i = 0; i < panel_count(); ++i) matrix.block(first_row(i), 0, rows_of(i), end_row(i)) = panel(i);
  matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
  return matrix;
}

void SymmetricMatrix::set_dense(const Eigen::MatrixXd& matrix) {
  panels_.clear();
  size_ = 0;
  resize(static_cast<int>(matrix.rows()));
  for (int i = 0; i < panel_count(); ++i) panel(i) = matrix.block(first_row(i), 0, rows_of(i), end_row(i));
}

void SymmetricMatrix::copy_columns(int start, Eigen::Ref<Eigen::MatrixXd> columns) const {
  const int own = panel_of(start);
  const auto count = columns.cols();
  columns.topRows(start) = panel(own).block(start - first_row(own), 0, count, start).transpose();
  for (int i = own; i < panel_count(); ++i) {
    const int first = std::max(first_row(i), start);
    columns.middleRows(first, end_row(i) - first) =
        panel(i).block(first - first_row(i), start, end_row(i) - first, count);
  }
  auto square = columns.middleRows(start, count);
  square.triangularView<Eigen::StrictlyUpper>() = square.transpose();
}

void SymmetricMatrix::set_columns(int start, const Tall& columns) {
  const int own = panel_of(start);
  const auto count = columns.cols();
  panel(own).block(start - first_row(own), 0, count, start) = columns.topRows(start).transpose();
  for (int i = own; i < panel_count(); ++i) {
    const int first = std::max(first_row(i), start);
    panel(i).block(first - first_row(i), start, end_row(i) - first, count) =
        columns.middleRows(first, end_row(i) - first);
  }
}

void SymmetricMatrix::add_product(double factor, const Tall& left, const Tall& right) {
  for (int i = 0; i < panel_count(); ++i) {
    add_product(i, factor, left.middleRows(first_row(i), rows_of(i)), right);
  }
}

void SymmetricMatrix::add_product(int panel, double factor, const Tall& left, const Tall& right) {
  constexpr int kTile = 128;  // columns: of kMostColumns factors they are packed on the stack
  auto target = this->panel(panel).topRows(left.rows());
  const int width = first_row(panel) + static_cast<int>(left.rows());
  for (int col = 0; col < width; col += kTile) {
    const int count = std::min(kTile, width - col);
    target.middleCols(col, count).noalias() += (factor * left) * right.middleRows(col, count).transpose();
  }
}

}  // namespace kinect_ekf_slam
