#include "kinect_ekf_slam/mapping/managed_map.h"

namespace kinect_ekf_slam {

template <class Space>
UpdateReport ManagedMap<Space>::observe(TimeNs stamp, const Observations& observations) {
  UpdateReport report = filter_->observe(stamp, observations);
  keep(stamp, observations, &report);
  return report;
}

template <class Space>
UpdateReport ManagedMap<Space>::apply(TimeNs stamp, const Observations& observations,
                                      std::vector<Assignment> assignments) {
  UpdateReport report = filter_->apply(stamp, observations, std::move(assignments));
  keep(stamp, observations, &report);
  return report;
}

/// A landmark where the robot is, which is not the life cycle's business.
template <class Space>
void ManagedMap<Space>::keep_position(TimeNs stamp, int id) {
  Observation<Space> here;
  constexpr double kExact = 1e-12;  // m^2
  here.covariance.diagonal().setConstant(kExact);
  filter_->apply(stamp, {here}, {Assignment{Verdict::kCreated, id}});
}

template <class Space>
void ManagedMap<Space>::keep(TimeNs stamp, const Observations& observations, UpdateReport* report) {
  if (!map_fixed_) life_cycle_.keep(stamp, observations, filter_.get(), report);
}

template <class Space>
SlamState<Space> ManagedMap<Space>::snapshot() const {
  const std::unique_ptr<KalmanSlam<Space>> filter = filter_->clone_filter();
  for (const LandmarkEstimate<Space>& landmark : filter_->landmarks()) {
    if (!landmark.info.confirmed) filter->remove(landmark.info.id);
  }
  return filter->snapshot();
}

template <class Space>
void ManagedMap<Space>::restore(const SlamState<Space>& state) {
  filter_->restore(state);
  life_cycle_.clear();
}

template <class Space>
void ManagedMap<Space>::set_map_fixed(bool fixed) {
  map_fixed_ = fixed;
  filter_->set_map_fixed(fixed);
}

template class ManagedMap<Planar>;
template class ManagedMap<Spatial>;

}  // namespace kinect_ekf_slam
