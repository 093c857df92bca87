#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/estimators/contradictions.h"
#include "kinect_ekf_slam/estimators/gaussian_state.h"
#include "kinect_ekf_slam/estimators/landmark_ids.h"
#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/estimators/scratch.h"
#include "kinect_ekf_slam/estimators/slam_estimator.h"

namespace kinect_ekf_slam {

/// What all Kalman estimators share: associate, correct in one joint update, add what is new, doubt what is
/// contradicted (docs/theory.md, section 4). What tells them apart is how the measurement is linearised and
/// how an error moves the estimate.
template <class Space>
class KalmanSlam : public SlamEstimator<Space> {
 public:
  KalmanSlam(const EstimatorOptions& options, std::shared_ptr<const Associator<Space>> associator,
             const PoseEstimate<Space>& initial)
      : options_(options),
        associator_(std::move(associator)),
        state_(initial),
        contradictions_(options),
        ids_(associator_->knows_identities()) {}

  using Observations = std::vector<Observation<Space>>;

  void predict(const MotionStep<Space>& step) override;
  UpdateReport observe(TimeNs stamp, const Observations& observations) override;
  LocateReport locate(const PoseMeasurement<Space>& measurement, int landmark_id, double gate) override;
  void add_landmark(int id, const typename Space::Point& position_in_map,
                    const typename Space::PointMatrix& covariance) override;
  void loosen(const typename Space::PoseMatrix& covariance) override;
  PoseEstimate<Space> pose() const override { return {state_.map_from_base(), state_.pose_covariance()}; }
  std::vector<LandmarkEstimate<Space>> landmarks() const override { return state_.landmarks(); }
  SlamState<Space> snapshot() const override { return state_.snapshot(); }
  void restore(const SlamState<Space>& state) override;
  void set_pose(const PoseEstimate<Space>& pose) override { state_.set_pose(pose); }
  void set_map_fixed(bool fixed) override { map_fixed_ = fixed; }
  virtual std::unique_ptr<KalmanSlam> clone_filter() const = 0;
  std::unique_ptr<SlamEstimator<Space>> clone() const override { return clone_filter(); }

  // The two halves of observe(), for one who decides on the association.
  class Expectation;
  /// What the filter expects to see of the landmarks that may have a part in what becomes of the
  /// observations. It looks at the filter, and holds until the filter changes.
  virtual Expectation expect(const Observations& observations);
  /// Corrects pose and map in one joint update and adds new landmarks, as the assignments say. Their indices
  /// are those of the expectation.
  UpdateReport apply(TimeNs stamp, const Observations& observations, std::vector<Assignment> assignments);

  // What a map's keeper may do to landmarks, by their ids. False, and nothing changed: there is no such one.
  bool set_confirmed(int id, bool confirmed);
  bool remove(int id);
  /// Two are one: their difference is zero, equation (10.1), and the second one goes. False, and nothing
  /// changed, when the difference's squared Mahalanobis distance is not below the gate.
  virtual bool merge(int kept_id, int dropped_id, double gate);

 protected:
  static constexpr int kPoseDim = Space::kPoseDim;
  static constexpr int kPointDim = Space::kPointDim;
  using Point = typename Space::Point;
  using PointMatrix = typename Space::PointMatrix;
  using PoseMatrix = typename Space::PoseMatrix;

  /// Sightings of mapped landmarks, as the joint update takes them.
  struct Match {
    std::size_t observation;
    int landmark;
    double squared_distance;
  };
  /// The joint measurement as the state predicts it: points in the base, one after the other.
  struct PredictedMeasurement {
    Eigen::Map<Eigen::VectorXd> mean;        ///< m
    Eigen::Map<Eigen::MatrixXd> cross;       ///< covariance of the state with it: P H^T
    Eigen::Map<Eigen::MatrixXd> covariance;  ///< of it, without the measurement's noise: H P H^T
  };

  /// Fills in what is there in its size.
  virtual void predict_measurement(const std::vector<Match>& matches, PredictedMeasurement* predicted) = 0;
  /// The same for what else tells where the robot is, of the pose and the landmark with this index, -1: none.
  /// The mean is -nu. False where nothing is predicted.
  virtual bool predict_measurement(const PoseMeasurement<Space>& measurement, int landmark,
                                   PredictedMeasurement* predicted) = 0;
  /// P -= U U^T, and the state moves by the error.
  virtual void correct(const Eigen::Ref<const Eigen::MatrixXd>& U,
                       const Eigen::Ref<const Eigen::VectorXd>& error) {
    add_correction(U, error);
  }
  /// Moves the state by an error: the whole of it, or the pose alone when that is all that is given.
  virtual void retract(const Eigen::Ref<const Eigen::VectorXd>& error) { add(error); }

  /// The rows of H that are not zero: by the pose's error, and by that of the one landmark seen.
  struct Jacobian {
    typename Space::PointByPose by_pose;
    PointMatrix by_landmark;
  };
  Jacobian jacobian(const Point& landmark_in_map, Point* point_in_base = nullptr) const;
  /// H_a P H_b^T of two landmarks, given the rows of P that it takes.
  static PointMatrix cross(const Jacobian& H_a, const Jacobian& H_b, const PoseMatrix& pose,
                           const typename Space::PointByPose& a_by_pose,
                           const typename Space::PointByPose& b_by_pose, const PointMatrix& a_by_b);

  // The state changes through these alone: an estimator that keeps more than the state takes part in them.
  virtual void move(const PoseEstimate<Space>& moved, const PoseMatrix& F) { state_.move(moved, F); }
  virtual void insert_landmark(LandmarkInfo info, const Point& landmark_in_map,
                               const typename Space::PointByPose& by_pose, const PointMatrix& independent) {
    state_.add_landmark(std::move(info), landmark_in_map, by_pose, independent);
  }
  virtual void remove_landmark(int index) { state_.remove_landmark(index); }
  /// After an update: S = L L^T, `L` with zeros above, `weighted` P H^T L^-T, `whitened` L^-1 nu.
  virtual void corrected(const std::vector<Match>& /*matches*/,
                         const Eigen::Ref<const Eigen::MatrixXd>& /*L*/,
                         const Eigen::Ref<const Eigen::MatrixXd>& /*weighted*/,
                         const Eigen::Ref<const Eigen::VectorXd>& /*whitened*/) {}
  /// Likewise, after locate().
  virtual void located(const Eigen::Ref<const Eigen::MatrixXd>& /*L*/,
                       const Eigen::Ref<const Eigen::MatrixXd>& /*weighted*/,
                       const Eigen::Ref<const Eigen::VectorXd>& /*whitened*/) {}
  /// Landmarks of the whole map; the state may hold a part of them.
  virtual int map_size() const { return state_.landmark_count(); }

  EstimatorOptions options_;
  std::shared_ptr<const Associator<Space>> associator_;
  GaussianState<Space> state_;
  bool map_fixed_ = false;

  /// Index in the state of the landmark, which may have to be brought there first; -1: there is none.
  virtual int index_of(int id);

 private:
  bool update(TimeNs stamp, const Observations& observations, const std::vector<Match>& matches,
              UpdateReport* report);
  /// x += K nu and P -= K S K^T, given nu, P H^T and S in their places; leaves L^-1 nu, P H^T L^-T and L,
  /// S = L L^T. False, and the state unchanged, when S is not positive definite.
  /// An absolute measurement is one of places in the map: the error of these adds up.
  bool take_in(PredictedMeasurement* innovation, bool is_absolute);
  void add(const Eigen::Ref<const Eigen::VectorXd>& error);
  void add_correction(const Eigen::Ref<const Eigen::MatrixXd>& U,
                      const Eigen::Ref<const Eigen::VectorXd>& error) {
    state_.correct(U);
    add(error);
  }
  /// R of a match, larger where the sighting is unlikely or says again what the last one said.
  PointMatrix measurement_noise(TimeNs stamp, const Observation<Space>& observation,
                                const Match& match) const;
  /// With the id given, kNoId: any.
  void map_sighting(TimeNs stamp, const Observation<Space>& observation, int id = kNoId);
  void replace_if_contradicted(TimeNs stamp, const Observations& observations, UpdateReport* report);

  Contradictions contradictions_;  ///< by the landmark's id
  LandmarkIds ids_;

  // Kept between updates: an update allocates nothing.
  std::vector<Match> matches_;
  Scratch mean_, cross_, covariance_, error_;
};

/// The associator's view of the filter.
template <class Space>
class KalmanSlam<Space>::Expectation : public PredictedMap<Space> {
 public:
  explicit Expectation(const KalmanSlam& filter) : filter_(&filter) {}
  int size() const override { return filter_->state_.landmark_count(); }
  const LandmarkInfo& info(int landmark) const override { return filter_->state_.info(landmark); }
  Point point_in_base(int landmark) const override;
  PointMatrix covariance(int landmark) const override { return cross_covariance(landmark, landmark); }
  PointMatrix cross_covariance(int a, int b) const override;

 private:
  const KalmanSlam* filter_;
};

}  // namespace kinect_ekf_slam
