#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/pipeline/options.h"
#include "kinect_ekf_slam/pipeline/sensor_frame.h"
#include "kinect_ekf_slam/simulation/evaluation.h"
#include "kinect_ekf_slam/simulation/simulator.h"

namespace kinect_ekf_slam {

/// The sample as the pipeline takes it, without the truth.
SensorFrame to_sensor_frame(const Sample& sample, const World& world);

/// The findings as the pipeline takes them.
std::vector<Detection> to_detections(const Findings& findings, const Eigen::Isometry3d& base_from_optical);

/// Finds landmarks in the pictures of one run, in their order. `up_in_optical`: where up is.
using FindInPicture =
    std::function<Findings(const RgbdPicture& picture, const Eigen::Vector3d& up_in_optical)>;

/// Many simulated runs of one world through the pipeline, each with the truth at hand.
struct RoomStudy {
  World world;
  PipelineOptions pipeline;
  std::uint64_t first_seed = 1;
  int seeds = 100;
  double odometry_delay = 0.0;  ///< s, at least 0; wheels and gyro are stamped so much later than they turned
  /// The detector of one run, where the world's pictures are to be rendered and what is found in them is to
  /// take the place of the simulated sightings; else empty.
  std::function<FindInPicture()> make_detector;
  std::function<void(double)> on_progress;  ///< share done, 0 to 1, from the calling thread; may be empty
};

/// What one run gave, compared in the space of the estimate. All in the start's own frame: the map's origin
/// is where the robot started.
struct RoomRun {
  std::uint64_t seed = 0;
  MapComparison map;
  int wrong_labels = 0;      ///< of the matched landmarks
  double path_rmse = 0.0;    ///< m, at the times of the detections, from the first move on
  int pose_dof = 0;          ///< 3 in the plane, 6 in space
  std::vector<double> nees;  ///< of the pose at the same times: e^T P^-1 e
  double nees_mean = 0.0;
  bool said_lost = false;  ///< at any time
  double seconds = 0.0;    ///< of simulated time

  /// Every landmark is in the map once, and nothing else.
  bool is_exact() const { return map.missed() == 0 && map.spurious() == 0; }
  /// Exact, and no worse than the report's own map: aligned RMSE at most 0.09 m.
  bool is_accurate() const { return map.rmse_aligned <= 0.09; }
  bool is_success() const { return is_exact() && is_accurate(); }
};

RoomRun run_room(const RoomStudy& study, std::uint64_t seed);

/// Runs all seeds on all cores; the results come in the order of the seeds.
std::vector<RoomRun> run_study(const RoomStudy& study);

/// Mean, median and worst over the runs.
struct Spread {
  double mean = 0.0;
  double median = 0.0;
  double worst = 0.0;
};

struct RoomSummary {
  std::size_t runs = 0;
  std::size_t true_landmarks = 0;
  double exact_count_share = 0.0;  ///< of the runs that are exact
  double success_share = 0.0;      ///< of the runs that are a success
  std::size_t silent_failures =
      0;  ///< runs whose landmarks are farther off than that and that never said lost
  Spread missed;
  Spread spurious;
  Spread wrong_labels;
  Spread landmark_rmse_aligned;  ///< m
  Spread landmark_rmse_start;    ///< m
  Spread path_rmse;              ///< m
  Spread nees;                   ///< `pose_dof` when consistent
  int pose_dof = 0;
  /// Where the mean over the runs lies at any one time with 95 % probability, if the estimate is consistent;
  /// and the share of the times at which it lies there.
  double nees_low = 0.0;
  double nees_high = 0.0;
  double nees_inside_share = 0.0;
};

RoomSummary summarize(const std::vector<RoomRun>& runs);

/// For people, and the same figures with those of every run for programs.
std::string to_table(const RoomSummary& summary);
std::string to_json(const RoomSummary& summary, const std::vector<RoomRun>& runs);

}  // namespace kinect_ekf_slam
