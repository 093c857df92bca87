#pragma once

#include <algorithm>
#include <memory>
#include <set>
#include <unordered_map>
#include <vector>

#include "kinect_ekf_slam/estimators/deferred_update.h"
#include "kinect_ekf_slam/estimators/ekf.h"

namespace kinect_ekf_slam {

/// The compressed EKF (Guivant and Nebot): the EKF of the robot's surroundings, at a cost that does not grow
/// with the map (docs/theory.md, section 9).
///
/// `state_` holds the pose and the active landmarks, those near the robot. The rest of the map learns what
/// they learnt after the region has changed, a little at each step, or when somebody asks. The estimate is
/// that of the EKF at any time: a landmark that an observation could be becomes active before the observation
/// is used.
template <class Space>
class CompressedEkf : public Ekf<Space> {
 public:
  CompressedEkf(const EstimatorOptions& options, std::shared_ptr<const Associator<Space>> associator,
                const PoseEstimate<Space>& initial);

  using typename KalmanSlam<Space>::Expectation;
  using typename KalmanSlam<Space>::Observations;
  Expectation expect(const Observations& observations) override;
  bool merge(int kept_id, int dropped_id, double gate) override;
  void loosen(const typename Space::PoseMatrix& covariance) override;
  std::vector<LandmarkEstimate<Space>> landmarks() const override;
  SlamState<Space> snapshot() const override;
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override;
  void set_map_fixed(bool fixed) override;
  std::unique_ptr<KalmanSlam<Space>> clone_filter() const override {
    return std::make_unique<CompressedEkf>(*this);
  }

  int active_landmarks() const { return state_.landmark_count(); }
  int region_changes() const { return region_changes_; }

 protected:
  using Base = Ekf<Space>;
  using Base::associator_;
  using Base::H_;
  using Base::kPointDim;
  using Base::kPoseDim;
  using Base::located_;
  using Base::map_fixed_;
  using Base::options_;
  using Base::state_;
  using typename Base::Match;
  using typename Base::Point;
  using typename Base::PointMatrix;
  using typename Base::PoseMatrix;
  void move(const PoseEstimate<Space>& moved, const PoseMatrix& F) override;
  void insert_landmark(LandmarkInfo info, const Point& landmark_in_map,
                       const typename Space::PointByPose& by_pose, const PointMatrix& independent) override;
  void remove_landmark(int index) override;
  void corrected(const std::vector<Match>& matches, const Eigen::Ref<const Eigen::MatrixXd>& L,
                 const Eigen::Ref<const Eigen::MatrixXd>& weighted,
                 const Eigen::Ref<const Eigen::VectorXd>& whitened) override;
  void located(const Eigen::Ref<const Eigen::MatrixXd>& L, const Eigen::Ref<const Eigen::MatrixXd>& weighted,
               const Eigen::Ref<const Eigen::VectorXd>& whitened) override;
  int index_of(int id) override;
  int map_size() const override {
    return std::max(whole_.landmark_count(), active_.empty() ? 0 : active_.back() + 1);
  }

 private:
  struct Passive {
    double distance;  ///< m, from the region's centre when the region was chosen
    int landmark;     ///< in the map
    bool operator<(const Passive& other) const { return distance < other.distance; }
  };

  /// Tells the map what the active part learnt, and leaves to `pending_` what takes long.
  void update_whole() { deferred_.apply(active_, state_, &whole_, &pending_); }
  /// The same, and leaves nothing.
  void finish_whole();
  /// Calls `change` with the whole map in `state_`, and begins the region anew.
  template <class Change>
  void change_whole(const Change& change);
  /// `state_` holds the whole map: the region begins anew.
  void start_anew();
  void change_region(const std::set<int>& others);
  /// The landmarks near the robot, the beacons, which reach far, and `others`.
  std::vector<int> choose_active(const std::set<int>& others) const;
  void activate(std::vector<int> landmarks);
  /// Passive landmarks that have a part in what becomes of the observations.
  std::set<int> concerned(const std::vector<Observation<Space>>& observations) const;
  void add_concerned(const Observation<Space>& observation, std::set<int>* landmarks) const;

  GaussianState<Space> whole_;  ///< the whole map as it was when the region became active, but for
  PendingUpdates<Space> pending_;
  std::vector<int> active_;  ///< of each landmark of the state its index in the map, ascending; the last
                             ///< may be new, and not in `whole_` yet
  DeferredUpdate<Space> deferred_;
  Scratch L_H_phi_;

  Point centre_ = Point::Zero();  ///< m, in the map: where the robot was when the region was chosen
  std::vector<Passive> passive_;  ///< by their distance
  double largest_sigma_ = 0.0;    ///< m, of the passive landmarks in `whole_`
  std::unordered_map<int, std::vector<int>> passive_of_identity_;
  int region_changes_ = 0;
};

}  // namespace kinect_ekf_slam
