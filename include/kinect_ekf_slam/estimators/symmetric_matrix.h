#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace kinect_ekf_slam {

/// A symmetric matrix that grows, of which half is stored: the covariance of a pose and a map.
///
/// Its lower triangle lies in panels, each of some rows up to the diagonal. New rows go below, into the last
/// panel or a new one, so what is stored never moves; and a product that is added passes once over the
/// memory, panel by panel. The first panel holds the pose's rows alone: no landmark lies in two.
class SymmetricMatrix {
 public:
  static constexpr int kPanelRows = 48;  ///< a multiple of a point's dimension, in the plane and in space

  explicit SymmetricMatrix(int first_rows) : first_rows_(first_rows) { resize(first_rows); }

  int size() const { return size_; }
  /// What is there stays; new rows are zero.
  void resize(int size);
  Eigen::MatrixXd dense() const;
  void set_dense(const Eigen::MatrixXd& matrix);

  /// A block whose rows lie in one panel, and whose columns do: of the pose and landmarks, one by one.
  template <int Rows, int Cols>
  Eigen::Matrix<double, Rows, Cols> block(int row, int col) const;
  /// Rows of one panel up to the diagonal, to be written. Of their last square the lower half counts.
  auto lower_rows(int row, int count) {
    const int panel = panel_of(row);
    return panels_[panel].block(row - first_row(panel), 0, count, row + count);
  }
  /// columns += this->middleCols(start, weights.rows()) * weights; these columns lie in one panel.
  template <class Weights, class Columns>
  void add_weighted_columns(int start, const Weights& weights, Columns&& columns) const;
  /// The columns from `start` on, which lie in one panel, in all rows.
  void copy_columns(int start, Eigen::Ref<Eigen::MatrixXd> columns) const;
  /// They become `columns`, and the rows likewise.
  void set_columns(int start, const Eigen::Ref<const Eigen::MatrixXd>& columns);

  using Tall = Eigen::Ref<const Eigen::MatrixXd>;  ///< as many rows as this, few columns
  /// this += factor * left * right^T, a product that is symmetric. Allocates nothing while the factors have
  /// no more than kMostColumns columns.
  void add_product(double factor, const Tall& left, const Tall& right);
  static constexpr int kMostColumns = 128;
  /// The same for rows of one panel, from its first one: `left` has no others.
  void add_product(int panel, double factor, const Tall& left, const Tall& right);

  // Panels, from the top. The part of a panel above the diagonal is never read.
  int panel_count() const { return panel_of(size_ - 1) + 1; }
  int panel_of(int row) const { return row < first_rows_ ? 0 : 1 + (row - first_rows_) / kPanelRows; }
  int first_row(int panel) const { return panel == 0 ? 0 : first_rows_ + (panel - 1) * kPanelRows; }
  int end_row(int panel) const { return std::min(first_row(panel + 1), size_); }
  auto panel(int index) { return panels_[index].topLeftCorner(rows_of(index), end_row(index)); }
  auto panel(int index) const { return panels_[index].topLeftCorner(rows_of(index), end_row(index)); }

 private:
  int rows_of(int panel) const { return end_row(panel) - first_row(panel); }

  int first_rows_;
  int size_ = 0;
  std::vector<Eigen::MatrixXd> panels_;
};

template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> SymmetricMatrix::block(int row, int col) const {
  if (row < col) return block<Cols, Rows>(col, row).transpose();
  const int panel = panel_of(row);
  Eigen::Matrix<double, Rows, Cols> block = panels_[panel].block<Rows, Cols>(row - first_row(panel), col);
  if constexpr (Rows == Cols) {
    if (row == col) {
      block.template triangularView<Eigen::StrictlyUpper>() = block.transpose();
    }
  }
  return block;
}

template <class Weights, class Columns>
void SymmetricMatrix::add_weighted_columns(int start, const Weights& weights, Columns&& columns) const {
  constexpr int kCount = Weights::RowsAtCompileTime;
  const auto count = weights.rows();
  const int own = panel_of(start);
  const int in_panel = start - first_row(own);
  const auto rows =
      panel(own).template middleRows<kCount>(in_panel, count);  // up to the diagonal, a transpose
  columns.topRows(start).noalias() += rows.leftCols(start).transpose() * weights;
  columns.middleRows(start, count).noalias() +=
      rows.template middleCols<kCount>(start, count).template selfadjointView<Eigen::Lower>() * weights;
  for (int i = own; i < panel_count(); ++i) {
    const int above = i == own ? in_panel + static_cast<int>(count) : 0;
    const auto below = panel(i).middleRows(above, rows_of(i) - above);
    columns.middleRows(first_row(i) + above, below.rows()).noalias() +=
        below.template middleCols<kCount>(start, count) * weights;
  }
}

}  // namespace kinect_ekf_slam
