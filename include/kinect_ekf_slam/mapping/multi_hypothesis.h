#pragma once

#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "kinect_ekf_slam/association/ranked_assignments.h"
#include "kinect_ekf_slam/mapping/managed_map.h"

namespace kinect_ekf_slam {

/// SLAM that does not decide on an ambiguous sighting at once: a map for each likely way to explain what was
/// seen, and what all of it says in the end decides (docs/theory.md, section 10; Reid, IEEE Trans. Automatic
/// Control 24(6), 1979).
///
/// What it tells is the likeliest hypothesis's. When that changes its mind about earlier sightings, the
/// report says so.
template <class Space>
class MultiHypothesis : public SlamEstimator<Space> {
 public:
  using Observations = std::vector<Observation<Space>>;

  MultiHypothesis(const ManagedMap<Space>& map, const AssociationOptions& options);
  MultiHypothesis(const MultiHypothesis& other);

  void predict(const MotionStep<Space>& step) override;
  UpdateReport observe(TimeNs stamp, const Observations& observations) override;
  /// The likeliest hypothesis decides whether the measurement is used; how well it fits counts for each.
  LocateReport locate(const PoseMeasurement<Space>& measurement, int landmark_id, double gate) override;
  void add_landmark(int id, const typename Space::Point& position_in_map,
                    const typename Space::PointMatrix& covariance) override;
  void loosen(const typename Space::PoseMatrix& covariance) override;
  PoseEstimate<Space> pose() const override { return best().map->pose(); }
  std::vector<LandmarkEstimate<Space>> landmarks() const override { return best().map->landmarks(); }
  SlamState<Space> snapshot() const override { return best().map->snapshot(); }
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override;
  void set_map_fixed(bool fixed) override;
  std::unique_ptr<SlamEstimator<Space>> clone() const override {
    return std::make_unique<MultiHypothesis>(*this);
  }

  int hypotheses() const { return static_cast<int>(hypotheses_.size()); }

 private:
  /// What a hypothesis takes a sighting for.
  struct Decision {
    TimeNs stamp = 0;
    int detection = 0;
    Assignment assignment;  ///< the landmark by its id
    bool operator==(const Decision& other) const;
  };
  struct Hypothesis {
    std::unique_ptr<ManagedMap<Space>> map;
    double log_weight = 0.0;
    std::deque<Decision> decisions;            ///< that are not final
    std::map<int, double> provisional_weight;  ///< what sightings of landmarks not confirmed yet have added
    Hypothesis copy() const;
  };
  struct Belief {
    PoseEstimate<Space> pose;
    std::vector<LandmarkEstimate<Space>> landmarks;
  };
  struct Branch {
    std::size_t parent = 0;
    RankedAssignment ranked;
    double log_weight = 0.0;
  };

  const Hypothesis& best() const { return hypotheses_.front(); }
  std::vector<Branch> branch(const Observations& observations);
  UpdateReport follow(TimeNs stamp, const Observations& observations, const RankedAssignment& ranked,
                      Hypothesis* hypothesis);
  /// Its sightings were clutter.
  static void forget(int landmark, Hypothesis* hypothesis);
  void drop_the_same();
  static bool is_same(const Belief& left, const Belief& right);
  void decide(TimeNs stamp);
  void tell_revisions(TimeNs stamp, UpdateReport* report);
  int new_id(std::size_t observation);

  AssociationOptions options_;
  AssignmentRanking<Space> ranking_;
  std::vector<Hypothesis> hypotheses_;  ///< the likeliest first; never empty
  std::deque<Decision> told_;           ///< the latest that was told about sightings that are not final
  std::map<std::size_t, int>
      ids_of_frame_;  ///< a sighting names the landmark that it creates, whoever believes it
  int unused_id_ = 0;
};

}  // namespace kinect_ekf_slam
