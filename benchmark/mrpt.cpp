#include "benchmark/benchmarks.h"

#ifdef HAVE_MRPT
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/slam/CRangeBearingKFSLAM2D.h>

#include "benchmark/drive.h"
#include "benchmark/step_times.h"

namespace kinect_ekf_slam::benchmarks {
namespace {

/// MRPT's planar EKF, with the sensor's true noise.
class Mrpt : public mrpt::slam::CRangeBearingKFSLAM2D {
 public:
  explicit Mrpt(mrpt::bayes::TKFMethod method) {
    KF_options.method = method;
    KF_options.verbosity_level = mrpt::system::LVL_ERROR;
    options.std_sensor_range = static_cast<float>(kRangeSigma);
    options.std_sensor_yaw = static_cast<float>(kBearingSigma);
    options.create_simplemap = false;
    getProfiler().disable();
  }

  void restore(const SlamState<Planar>& state) {
    const auto size = state.covariance.rows();
    m_xkk.resize(size);
    m_pkk.setSize(size, size);
    const auto& pose = state.map_from_base;
    m_xkk[0] = pose.translation().x();
    m_xkk[1] = pose.translation().y();
    m_xkk[2] = pose.angle();
    for (Eigen::Index i = 3; i < size; ++i) m_xkk[i] = state.landmarks_in_map[i - 3];
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = 0; j < size; ++j) m_pkk(i, j) = state.covariance(i, j);
    }
    for (std::size_t i = 0; i < state.infos.size(); ++i) {
      m_IDs.insert(state.infos[i].source_id, static_cast<unsigned>(i));
    }
  }

  std::size_t landmark_count() const { return (getStateVectorLength() - 3) / 2; }
};

/// A look as MRPT takes it.
struct MrptLook {
  mrpt::obs::CActionCollection::Ptr actions = mrpt::obs::CActionCollection::Create();
  mrpt::obs::CSensoryFrame::Ptr frame = mrpt::obs::CSensoryFrame::Create();

  explicit MrptLook(const Look& look) {
    mrpt::obs::CActionRobotMovement2D action;
    const Se2& delta = look.motion.delta;
    action.estimationMethod = mrpt::obs::CActionRobotMovement2D::emOdometry;
    auto change = mrpt::poses::CPosePDFGaussian::Create();
    change->mean = {delta.translation().x(), delta.translation().y(), delta.angle()};
    for (int i = 0; i < 3; ++i) change->cov(i, i) = look.motion.covariance(i, i);
    action.poseChange.get_ptr() = change;
    actions->insert(action);
    auto seen = mrpt::obs::CObservationBearingRange::Create();
    seen->setSensorPose(mrpt::poses::CPose3D());
    for (const Polar& polar : look.sightings) {
      auto& measurement = seen->sensedData.emplace_back();
      measurement.range = static_cast<float>(polar.range);
      measurement.yaw = static_cast<float>(polar.bearing);
      measurement.pitch = 0.0F;
      measurement.landmarkID = polar.identity;
    }
    frame->insert(seen);
  }
};

void update(benchmark::State& state, mrpt::bayes::TKFMethod method) {
  Drive drive(static_cast<int>(state.range(0)));
  Mrpt filter(method);
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
  if (static_cast<int>(filter.landmark_count()) != drive.landmark_count()) {
    state.SkipWithError("MRPT took known landmarks for new ones");
  }
}

void insert(benchmark::State& state, mrpt::bayes::TKFMethod method) {
  std::vector<MrptLook> looks;
  for (const Look& look : survey(static_cast<int>(state.range(0)))) looks.emplace_back(look);
  StepTimes times;
  for (auto _ : state) {
    Mrpt filter(method);
    times.measure(state, [&] {
      for (MrptLook& look : looks) filter.processActionObservation(look.actions, look.frame);
    });
    if (static_cast<int>(filter.landmark_count()) != state.range(0))
      state.SkipWithError("landmarks are missing");
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
    add("update/mrpt_davison", update, mrpt::bayes::kfEKFAlaDavison, n, n < 500 ? 100 : 2000 * 5 / n);
    add("update/mrpt_full", update, mrpt::bayes::kfEKFNaive, n, n < 500 ? 50 : n < 2000 ? 3000 / n : 1);
  }
  add("insert/mrpt_davison", insert, mrpt::bayes::kfEKFAlaDavison, 2000, 1);
}

}  // namespace kinect_ekf_slam::benchmarks

#else

namespace kinect_ekf_slam::benchmarks {
void register_mrpt() {}
}  // namespace kinect_ekf_slam::benchmarks

#endif
