#include "benchmark/benchmarks.h"

#ifdef HAVE_MRPT
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/slam/CRangeBearingKFSLAM.h>
#include <mrpt/slam/CRangeBearingKFSLAM2D.h>

#include "benchmark/drive.h"
#include "benchmark/step_times.h"

namespace kinect_ekf_slam::benchmarks {
namespace {

template <class Space>
struct Names;
template <>
struct Names<Planar> {
  using Filter = mrpt::slam::CRangeBearingKFSLAM2D;
  static constexpr int kPose = 3;  // numbers of the state
  /// d(pose as MRPT has it)/d(our tangent), where the robot looks along x.
  static Eigen::Matrix3d by_tangent() { return Eigen::Matrix3d::Identity(); }
  static Eigen::Vector3d pose(const Se2& pose) { return Planar::to_vector(pose); }
  static void move(const MotionStep<Planar>& motion, mrpt::obs::CActionCollection* actions) {
    mrpt::obs::CActionRobotMovement2D action;
    action.estimationMethod = mrpt::obs::CActionRobotMovement2D::emOdometry;
    auto change = mrpt::poses::CPosePDFGaussian::Create();
    change->mean = {motion.delta.translation().x(), motion.delta.translation().y(), motion.delta.angle()};
    for (int i = 0; i < 3; ++i) change->cov(i, i) = motion.covariance(i, i);
    action.poseChange.get_ptr() = change;
    actions->insert(action);
  }
};
template <>
struct Names<Spatial> {
  using Filter = mrpt::slam::CRangeBearingKFSLAM;
  static constexpr int kPose = 7;  // position and quaternion
  template <class Options>
  static void set_sensor(Options* options) {
    options->std_sensor_pitch = static_cast<float>(kBearingSigma);
  }
  static Eigen::Matrix<double, 7, 6> by_tangent() {
    Eigen::Matrix<double, 7, 6> by_tangent = Eigen::Matrix<double, 7, 6>::Zero();
    by_tangent.topLeftCorner<3, 3>().setIdentity();
    by_tangent.bottomRightCorner<3, 3>().diagonal().setConstant(0.5);
    return by_tangent;
  }
  static Eigen::Matrix<double, 7, 1> pose(const Se3& pose) {
    const Eigen::Quaterniond& q = pose.attitude();
    return (Eigen::Matrix<double, 7, 1>() << pose.translation(), q.w(), q.x(), q.y(), q.z()).finished();
  }
  static void move(const MotionStep<Spatial>& motion, mrpt::obs::CActionCollection* actions) {
    mrpt::obs::CActionRobotMovement3D action;
    action.estimationMethod = mrpt::obs::CActionRobotMovement3D::emOdometry;
    const Eigen::Vector3d& shift = motion.delta.translation();
    const double yaw = rotation_log(motion.delta.attitude()).z();  // the robot drives on the ground
    action.poseChange.mean = mrpt::poses::CPose3D(shift.x(), shift.y(), shift.z(), yaw, 0.0, 0.0);
    constexpr int kAxes[] = {0, 1, 2, 5, 4, 3};  // MRPT's order of angles is yaw, pitch, roll
    for (int i = 0; i < 6; ++i) action.poseChange.cov(i, i) = motion.covariance(kAxes[i], kAxes[i]);
    actions->insert(action);
  }
};

/// MRPT's EKF, with the sensor's true noise.
template <class Space>
class Mrpt : public Names<Space>::Filter {
 public:
  explicit Mrpt(mrpt::bayes::TKFMethod method) {
    this->KF_options.method = method;
    this->KF_options.verbosity_level = mrpt::system::LVL_ERROR;
    this->options.std_sensor_range = static_cast<float>(kRangeSigma);
    this->options.std_sensor_yaw = static_cast<float>(kBearingSigma);
    if constexpr (Space::kPointDim == 3) Names<Space>::set_sensor(&this->options);
    this->options.create_simplemap = false;
    this->getProfiler().disable();
  }

  void restore(const SlamState<Space>& state) {
    constexpr int kPose = Names<Space>::kPose;
    const auto map_size = state.landmarks_in_map.size();
    Eigen::MatrixXd by_ours = Eigen::MatrixXd::Zero(kPose, Space::kPoseDim);
    by_ours = Names<Space>::by_tangent();
    Eigen::MatrixXd P(kPose + map_size, kPose + map_size);
    P.topLeftCorner(kPose, kPose) =
        by_ours * state.covariance.topLeftCorner(Space::kPoseDim, Space::kPoseDim) * by_ours.transpose();
    P.topRightCorner(kPose, map_size) = by_ours * state.covariance.topRightCorner(Space::kPoseDim, map_size);
    P.bottomLeftCorner(map_size, kPose) = P.topRightCorner(kPose, map_size).transpose();
    P.bottomRightCorner(map_size, map_size) = state.covariance.bottomRightCorner(map_size, map_size);
    Eigen::VectorXd x(P.rows());
    x << Names<Space>::pose(state.map_from_base), state.landmarks_in_map;
    this->m_xkk.resize(P.rows());
    this->m_pkk.setSize(P.rows(), P.cols());
    for (Eigen::Index i = 0; i < P.rows(); ++i) {
      this->m_xkk[i] = x(i);
      for (Eigen::Index j = 0; j < P.cols(); ++j) this->m_pkk(i, j) = P(i, j);
    }
    for (std::size_t i = 0; i < state.infos.size(); ++i) {
      this->m_IDs.insert(state.infos[i].source_id, static_cast<unsigned>(i));
    }
  }

  int landmark_count() const {
    return (static_cast<int>(this->getStateVectorLength()) - Names<Space>::kPose) / Space::kPointDim;
  }
};

/// A look as MRPT takes it.
struct MrptLook {
  mrpt::obs::CActionCollection::Ptr actions = mrpt::obs::CActionCollection::Create();
  mrpt::obs::CSensoryFrame::Ptr frame = mrpt::obs::CSensoryFrame::Create();

  template <class Space>
  explicit MrptLook(const Look<Space>& look) {
    Names<Space>::move(look.motion, actions.get());
    auto seen = mrpt::obs::CObservationBearingRange::Create();
    seen->setSensorPose(mrpt::poses::CPose3D());
    for (const Polar& polar : look.sightings) {
      auto& measurement = seen->sensedData.emplace_back();
      measurement.range = static_cast<float>(polar.range);
      measurement.yaw = static_cast<float>(polar.bearing);
      measurement.pitch = static_cast<float>(-polar.elevation);  // MRPT's pitch looks down
      measurement.landmarkID = polar.identity;
    }
    frame->insert(seen);
  }
};

template <class Space>
void update(benchmark::State& state, mrpt::bayes::TKFMethod method) {
  Drive<Space> drive(static_cast<int>(state.range(0)));
  Mrpt<Space> filter(method);
  filter.restore(drive.known_map());
  StepTimes times;
  const auto step = [&](const auto& measure) {
    MrptLook look(drive.next());
    measure([&] { filter.processActionObservation(look.actions, look.frame); });
  };
  step([](const auto& work) { work(); });
  for (auto _ : state) {
    step([&](const auto& work) { times.measure(state, work); });
  }
  times.report(state);
  if (filter.landmark_count() != drive.landmark_count()) {
    state.SkipWithError("MRPT took known landmarks for new ones");
  }
}

void insert(benchmark::State& state, mrpt::bayes::TKFMethod method) {
  std::vector<MrptLook> looks;
  for (const auto& look : survey<Planar>(static_cast<int>(state.range(0)))) {
    if (!look.sightings.empty()) looks.emplace_back(look);
  }
  StepTimes times;
  for (auto _ : state) {
    Mrpt<Planar> filter(method);
    times.measure(state, [&] {
      for (MrptLook& look : looks) filter.processActionObservation(look.actions, look.frame);
    });
    if (filter.landmark_count() != state.range(0)) state.SkipWithError("landmarks are missing");
  }
  times.report(state);
}

}  // namespace

void register_mrpt() {
  const auto add = [](const char* name, const auto& function, auto method, int landmarks, int iterations) {
    benchmark::RegisterBenchmark(name, function, method)
        ->Arg(landmarks)
        ->Iterations(iterations)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  for (const int n : {50, 100, 200, 500, 1000, 2000}) {
    add("update/mrpt_davison", update<Planar>, mrpt::bayes::kfEKFAlaDavison, n, n < 500 ? 100 : 2000 * 5 / n);
    add("update/mrpt_full", update<Planar>, mrpt::bayes::kfEKFNaive, n,
        n < 500    ? 50
        : n < 2000 ? 3000 / n
                   : 1);
  }
  for (const int n : {50, 100, 200, 500}) {
    add("spatial/mrpt_davison", update<Spatial>, mrpt::bayes::kfEKFAlaDavison, n, n < 500 ? 50 : 5);
    add("spatial/mrpt_full", update<Spatial>, mrpt::bayes::kfEKFNaive, n, n < 500 ? 50 : 5);
  }
  add("insert/mrpt_davison", insert, mrpt::bayes::kfEKFAlaDavison, 2000, 1);
}

}  // namespace kinect_ekf_slam::benchmarks

#else

namespace kinect_ekf_slam::benchmarks {
void register_mrpt() {}
}  // namespace kinect_ekf_slam::benchmarks

#endif
