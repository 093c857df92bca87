#include "kinect_ekf_slam/estimators/symmetric_matrix.h"

#include <algorithm>

#include "kinect_ekf_slam/estimators/wide_product.h"

namespace kinect_ekf_slam {
namespace {

using Tall = SymmetricMatrix::Tall;

/// The first columns of a panel, as many as it can: panel += factor * left * right^T. Returns how many.
int add_wide(double factor, const Tall& left, const Tall& right, double* panel, int width) {
  constexpr int kTile = 32;  // columns, that are packed on the stack
  alignas(32) double packed_left[kWideRows * SymmetricMatrix::kMostColumns];
  alignas(32) double packed_right[kTile * SymmetricMatrix::kMostColumns];
  const int end = width - width % kWideColumns;
  const auto depth = left.cols();
  if (depth > SymmetricMatrix::kMostColumns) return 0;
  Eigen::Map<Eigen::MatrixXd> all_rows(packed_left, kWideRows, depth);
  all_rows.topRows(left.rows()) = factor * left;
  all_rows.bottomRows(kWideRows - left.rows()).setZero();
  for (int col = 0; col < end; col += kTile) {
    const int count = std::min(kTile, end - col);
    Eigen::Map<Eigen::MatrixXd>(packed_right, depth, count) = right.middleRows(col, count).transpose();
    add_wide_product(panel + Eigen::Index{col} * kWideRows, count, packed_left, packed_right,
                     static_cast<int>(depth));
  }
  return end;
}

}  // namespace

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
  static_assert(kPanelRows == kWideRows);
  constexpr int kTile = 128;  // columns: of kMostColumns factors they are packed on the stack
  auto target = this->panel(panel).topRows(left.rows());
  const int width = first_row(panel) + static_cast<int>(left.rows());
  const bool is_wide = panel > 0 && has_wide_product();
  for (int col = is_wide ? add_wide(factor, left, right, panels_[panel].data(), width) : 0; col < width;
       col += kTile) {
    const int count = std::min(kTile, width - col);
    target.middleCols(col, count).noalias() += (factor * left) * right.middleRows(col, count).transpose();
  }
}

}  // namespace kinect_ekf_slam
