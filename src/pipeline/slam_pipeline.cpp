#include "kinect_ekf_slam/pipeline/slam_pipeline.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "kinect_ekf_slam/pipeline/landmark_3d.h"
#include "kinect_ekf_slam/pipeline/motion_track.h"
#include "kinect_ekf_slam/pipeline/position_updates.h"
#include "kinect_ekf_slam/pipeline/relocalizer.h"
#include "kinect_ekf_slam/pipeline/sightings.h"

namespace kinect_ekf_slam {
namespace {

Pose3d initial_pose(const InitialPoseOptions& options) {
  Pose3d pose;
  pose.map_from_base.translation() = Eigen::Vector3d(options.x, options.y, options.z);
  pose.map_from_base.linear() =
      rotation_from_rpy({radians(options.roll_deg), radians(options.pitch_deg), radians(options.yaw_deg)});
  const double heading_sigma = radians(options.heading_sigma_deg);
  pose.covariance.diagonal() << Eigen::Vector3d::Constant(options.position_sigma * options.position_sigma),
      Eigen::Vector3d::Constant(heading_sigma * heading_sigma);
  return pose;
}

template <class Space>
class SpacePipeline : public SlamPipeline {
 public:
  explicit SpacePipeline(const PipelineOptions& options)
      : seed_(options.estimator.seed),
        relocalize_when_lost_(options.relocalize_when_lost),
        sensor_(options.sensor),
        motion_(options.input, options.motion),
        estimator_(make_slam<Space>(options.estimator, options.association, options.life_cycle,
                                    to_estimate<Space>(initial_pose(options.initial_pose)))),
        positions_(options.positions),
        dead_reckoned_(estimator_->pose().map_from_base) {
    positions_.add_beacons(estimator_.get());
    set_mode(options.mode);
  }

  SlamResult process(const SensorFrame& frame) override {
    const bool late = motion_.is_past(frame.stamp);
    if (const auto step = motion_.advance(frame)) {
      estimator_->predict(*step);
      relocalizer_.predict(*step);
      dead_reckoned_ = dead_reckoned_ * step->delta;
    }
    SlamResult result;
    positions_.take(frame, late, estimator_.get(), &result);
    if (frame.detections) {
      result.looked = true;
      observe(*frame.detections, late, &result);
    }
    result.pose = to_3d<Space>(motion_.now(), estimator_->pose());
    result.dead_reckoned = Space::to_3d(dead_reckoned_);
    result.localization = positions_.is_lost() ? Localization::kLost : relocalizer_.state();
    result.map_from_global = positions_.map_from_global();
    result.finite = result.pose.map_from_base.matrix().allFinite() && result.pose.covariance.allFinite();
    return result;
  }

  Pose3d look_ahead(const std::deque<SensorFrame>& waiting, TimeNs stamp) const override {
    MotionTrack<Space> motion = motion_;
    PoseEstimate<Space> pose = estimator_->pose();
    for (const SensorFrame& frame : waiting) {
      if (frame.stamp > stamp) break;
      if (const auto step = motion.advance(frame)) predict_pose(*step, &pose);
    }
    if (const auto step = motion.advance_to(stamp)) predict_pose(*step, &pose);
    return to_3d<Space>(motion.now(), pose);
  }

  std::vector<Landmark3d> map() const override {
    std::vector<Landmark3d> map;
    for (const LandmarkEstimate<Space>& estimate : seen_landmarks()) map.push_back(to_3d<Space>(estimate));
    return map;
  }

  std::vector<Landmark3d> beacons() const override {
    std::vector<Landmark3d> beacons;
    for (const LandmarkEstimate<Space>& estimate : estimator_->landmarks()) {
      if (!is_beacon(estimate.info.id)) continue;
      Landmark3d beacon = to_3d<Space>(estimate);
      beacon.id = beacon_of(estimate.info.id);
      beacon.label = "beacon";
      if (Space::kPointDim < 3) beacon.position_in_map.z() = positions_.beacon_height(beacon.id);
      beacons.push_back(std::move(beacon));
    }
    return beacons;
  }

  SavedState save() const override {
    const SlamState<Space> state = estimator_->snapshot();
    const auto count = static_cast<Eigen::Index>(state.infos.size());
    SavedState saved;
    saved.space = Space::kName;
    saved.stamp = motion_.now();
    saved.pose = Space::to_vector(state.map_from_base);
    saved.infos = state.infos;
    saved.landmarks_in_map =
        Eigen::Map<const Eigen::MatrixXd>(state.landmarks_in_map.data(), Space::kPointDim, count).transpose();
    saved.covariance = state.covariance;
    return saved;
  }

  void load(const SavedState& saved, bool keep_saved_pose) override {
    if (saved.space != Space::kName) {
      throw std::invalid_argument("the map is " + saved.space + ", estimator/space is " + Space::kName);
    }
    const PoseEstimate<Space> present = estimator_->pose();
    const Eigen::MatrixXd points = saved.landmarks_in_map.transpose();
    std::vector<LandmarkInfo> infos = saved.infos;
    for (LandmarkInfo& info : infos) info.last_seen = 0;  // in this run, whose clock may be another
    estimator_->restore({Space::pose_from_vector(saved.pose), std::move(infos),
                         Eigen::Map<const Eigen::VectorXd>(points.data(), points.size()), saved.covariance});
    if (!keep_saved_pose) estimator_->set_pose(present);
    positions_.map_was_replaced();
    positions_.add_beacons(estimator_.get());
    relocalizer_.stop();
    dead_reckoned_ = estimator_->pose().map_from_base;
  }

  void set_pose(const Pose3d& pose) override {
    estimator_->set_pose(to_estimate<Space>(pose));
    positions_.pose_was_set();
    relocalizer_.stop();
    dead_reckoned_ = estimator_->pose().map_from_base;
  }

  void set_mode(Mode mode) override {
    mode_ = mode;
    relocalizer_.stop();
    estimator_->set_map_fixed(mode == Mode::kLocalization);
  }

  void relocalize() override {
    auto map = seen_landmarks();
    if (mode_ != Mode::kLocalization || map.empty()) {
      throw std::invalid_argument("the robot is looked for in mode localization, with a map");
    }
    PoseEstimate<Space> unknown = estimator_->pose();
    constexpr double kUnknown = 10.0;  // m; a turn of any angle has the variance pi^2 / 3
    unknown.covariance.setIdentity();
    unknown.covariance *= kPi * kPi / 3.0;
    unknown.covariance.template topLeftCorner<Space::kPointDim, Space::kPointDim>() *= kUnknown * kUnknown;
    estimator_->set_pose(unknown);
    LocalizationOptions options;
    options.seed = seed_;
    relocalizer_.start(options, std::move(map));
  }

  void set_live_options(const PipelineOptions& options) override {
    sensor_ = options.sensor;
    motion_.set_options(options.motion);
    motion_.conditioner().set_options(options.input);
  }

  const Eigen::Vector3d& gyro_bias() const override { return motion_.conditioner().gyro_bias(); }

 private:
  std::vector<LandmarkEstimate<Space>> seen_landmarks() const {
    std::vector<LandmarkEstimate<Space>> landmarks = estimator_->landmarks();
    landmarks.erase(std::remove_if(landmarks.begin(), landmarks.end(),
                                   [](const auto& landmark) { return is_beacon(landmark.info.id); }),
                    landmarks.end());
    return landmarks;
  }

  void observe(const std::vector<Detection>& detections, bool late, SlamResult* result) {
    const Sightings<Space> seen(detections, sensor_);
    result->outcomes.resize(detections.size());
    for (std::size_t i = 0; i < detections.size(); ++i) {
      DetectionOutcome& outcome = result->outcomes[i];
      outcome.source_id = detections[i].signature.source_id;
      outcome.position_in_map = detections[i].position_in_base;  // moved into the map below
      outcome.verdict = late ? Verdict::kLate : seen.refusals[i];
    }
    if (!late) {
      UpdateReport report = estimate(seen.observations);
      result->nis = report.nis;
      result->dof = report.dof;
      result->removed = std::move(report.removed);
      result->merged = std::move(report.merged);
      for (const Revision& revision : report.revisions) {
        const Assignment& assignment = revision.assignment;
        result->revisions.push_back({revision.stamp, revision.detection, assignment.verdict,
                                     assignment.landmark, assignment.squared_distance});
      }
      for (std::size_t k = 0; k < seen.observations.size(); ++k) {
        DetectionOutcome& outcome = result->outcomes[seen.detection_of_observation[k]];
        outcome.verdict = report.assignments[k].verdict;
        outcome.landmark_id = report.assignments[k].landmark;
        outcome.nis = report.assignments[k].squared_distance;
      }
    }
    const Eigen::Isometry3d map_from_base = Space::to_3d(estimator_->pose().map_from_base);
    for (DetectionOutcome& outcome : result->outcomes) {
      outcome.position_in_map = map_from_base * outcome.position_in_map;
    }
  }

  UpdateReport estimate(const std::vector<Observation<Space>>& observations) {
    UpdateReport report;
    if (relocalizer_.is_searching()) {
      report.assignments.assign(observations.size(), {Verdict::kAmbiguous});
      if (observations.empty()) return report;
      if (const auto found = relocalizer_.search(observations)) {
        estimator_->set_pose(*found);
        dead_reckoned_ = found->map_from_base;
      }
      return report;
    }
    report = estimator_->observe(motion_.now(), observations);
    relocalizer_.judge(report);
    const bool may_search = mode_ == Mode::kLocalization && relocalize_when_lost_;
    if (may_search && relocalizer_.is_lost() && !seen_landmarks().empty()) relocalize();
    return report;
  }

  Mode mode_ = Mode::kSlam;
  int seed_;
  bool relocalize_when_lost_;
  SensorOptions sensor_;
  MotionTrack<Space> motion_;
  Relocalizer<Space> relocalizer_;
  std::unique_ptr<SlamEstimator<Space>> estimator_;
  PositionUpdates<Space> positions_;
  typename Space::Pose dead_reckoned_;
};

}  // namespace

std::unique_ptr<SlamPipeline> make_pipeline(const PipelineOptions& options) {
  if (options.space == SpaceType::kSpatial) return std::make_unique<SpacePipeline<Spatial>>(options);
  return std::make_unique<SpacePipeline<Planar>>(options);
}

}  // namespace kinect_ekf_slam
