#include "kinect_ekf_slam/estimators/pending_updates.h"

#include <algorithm>
#include <utility>

namespace kinect_ekf_slam {

template <class Space>
void PendingUpdates<Space>::add(Eigen::MatrixXd columns, Eigen::MatrixXd psi) {
  updates_.push_back({std::move(columns), std::move(psi)});
}

template <class Space>
void PendingUpdates<Space>::settle(const std::vector<int>& landmarks) {
  for (Update& update : updates_) {
    GaussianState<Space>::for_each_block(landmarks, [&](int row, int /*in_part*/, int count) {
      if (row < update.columns.rows()) update.columns.middleRows(row, count).setZero();
    });
  }
}

template <class Space>
void PendingUpdates<Space>::advance(SymmetricMatrix* P) {
  const int slice = (P->panel_count() + kSteps - 1) / kSteps;
  for (Update& update : updates_) advance(slice, &update, P);
  while (static_cast<int>(updates_.size()) > kMost) {
    advance(P->panel_count(), &updates_.front(), P);
    updates_.pop_front();
  }
  while (!updates_.empty() && updates_.front().done == P->panel_count()) updates_.pop_front();
}

template <class Space>
void PendingUpdates<Space>::finish(SymmetricMatrix* P) {
  for (Update& update : updates_) advance(P->panel_count(), &update, P);
  updates_.clear();
}

template <class Space>
void PendingUpdates<Space>::advance(int panels, Update* update, SymmetricMatrix* P) {
  const int end = std::min(update->done + panels, P->panel_count());
  for (; update->done < end; ++update->done) {
    const int first = P->first_row(update->done);
    const int rows = std::min(P->end_row(update->done), static_cast<int>(update->columns.rows())) - first;
    if (rows <= 0) continue;  // of landmarks that are younger
    const Eigen::MatrixXd weighted = update->columns.middleRows(first, rows) * update->psi;
    P->add_product(update->done, -1.0, weighted, update->columns);
  }
}

template <class Space>
void PendingUpdates<Space>::correct_columns(const SymmetricMatrix& P, const std::vector<int>& landmarks,
                                            Eigen::MatrixXd* columns) const {
  for (const Update& update : updates_) {
    // The columns it concerns: first those that lie in panels that are done, of which the rows below are not.
    std::vector<int> concerned;
    int of_done = 0;
    Eigen::MatrixXd rows(columns->cols(), update.columns.cols());
    GaussianState<Space>::for_each_block(landmarks, [&](int row, int in_part, int count) {
      if (row >= update.columns.rows() || update.columns.middleRows(row, count).isZero(0.0)) return;
      if (P.panel_of(row) < update.done) of_done += count;
      for (int k = 0; k < count; ++k) {
        rows.row(static_cast<Eigen::Index>(concerned.size())) = update.columns.row(row + k);
        concerned.push_back(in_part + k);
      }
    });
    const auto count = static_cast<Eigen::Index>(concerned.size());
    const Eigen::MatrixXd weights = update.psi * rows.topRows(count).transpose();
    const auto split = std::min<Eigen::Index>(P.first_row(update.done), update.columns.rows());
    Eigen::MatrixXd learnt = Eigen::MatrixXd::Zero(update.columns.rows(), count);
    learnt.topRightCorner(split, count - of_done).noalias() =
        update.columns.topRows(split) * weights.rightCols(count - of_done);
    learnt.bottomRows(learnt.rows() - split).noalias() =
        update.columns.bottomRows(learnt.rows() - split) * weights;
    for (Eigen::Index k = 0; k < count; ++k) {
      columns->col(concerned[static_cast<std::size_t>(k)]).head(learnt.rows()) -= learnt.col(k);
    }
  }
}

template <class Space>
void PendingUpdates<Space>::correct_covariance(const SymmetricMatrix& P, int landmark,
                                               PointMatrix* covariance) const {
  const int row = GaussianState<Space>::row(landmark);
  for (const Update& update : updates_) {
    if (row >= update.columns.rows() || P.panel_of(row) < update.done) continue;
    const auto rows = update.columns.template middleRows<kPointDim>(row);
    const PointMatrix learnt = rows * (update.psi * rows.transpose());
    *covariance -= PointMatrix(learnt.template selfadjointView<Eigen::Lower>());
  }
}

template class PendingUpdates<Planar>;
template class PendingUpdates<Spatial>;

}  // namespace kinect_ekf_slam
