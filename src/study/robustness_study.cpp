#include "kinect_ekf_slam/study/robustness_study.h"

#include <algorithm>

#include "kinect_ekf_slam/study/monte_carlo.h"
#include "kinect_ekf_slam/study/text.h"

namespace kinect_ekf_slam {
namespace {

/// The study at one point for one of the two pipelines, and where its summary goes.
struct Job {
  RoomStudy study;
  RoomSummary* summary;
};

std::vector<double> with_base(std::vector<double> strengths, double base) {
  strengths.push_back(base);
  std::sort(strengths.begin(), strengths.end());
  strengths.erase(std::unique(strengths.begin(), strengths.end()), strengths.end());
  return strengths;
}

std::string figures(const RoomSummary& summary) {
  const Spread& rmse = summary.landmark_rmse_aligned;
  return format("%8.0f %% %8.3f %7.3f %9.1f", 100.0 * summary.success_share, rmse.median, rmse.worst,
                summary.spurious.mean);
}

std::string to_json(const FaultSweep& sweep, RoomSummary RobustnessPoint::*variant) {
  std::vector<double> success;
  std::vector<double> exact;
  std::vector<double> spurious;
  std::vector<double> median;
  std::vector<double> worst;
  std::vector<double> path;
  for (const RobustnessPoint& point : sweep.points) {
    const RoomSummary& summary = point.*variant;
    success.push_back(summary.success_share);
    exact.push_back(summary.exact_count_share);
    spurious.push_back(summary.spurious.mean);
    median.push_back(summary.landmark_rmse_aligned.median);
    worst.push_back(summary.landmark_rmse_aligned.worst);
    path.push_back(summary.path_rmse.median);
  }
  return "{\"success_share\": " + json(success) + ", \"exact_count_share\": " + json(exact) +
         ", \"landmarks_spurious_mean\": " + json(spurious) +
         ",\n   \"landmark_rmse_median_m\": " + json(median) + ", \"landmark_rmse_worst_m\": " + json(worst) +
         ", \"path_rmse_median_m\": " + json(path) + "}";
}

}  // namespace

std::vector<Fault> common_faults() {
  return {
      {"gross errors",
       "share of the detections",
       {0.0, 0.02, 0.05, 0.1, 0.2, 0.4},
       [](RoomStudy& study) -> double& { return study.world.sensor.gross_error_rate; }},
      {"false detections",
       "a minute",
       {0.0, 2.0, 6.0, 20.0, 60.0},
       [](RoomStudy& study) -> double& { return study.world.sensor.false_per_minute; }},
      {"missed detections",
       "share of the sightings",
       {0.0, 0.2, 0.4, 0.6, 0.8},
       [](RoomStudy& study) -> double& { return study.world.sensor.miss_rate; }},
      {"wrong labels",
       "share of the detections",
       {0.0, 0.02, 0.05, 0.1, 0.2},
       [](RoomStudy& study) -> double& { return study.world.sensor.wrong_label_rate; }},
      {"slip",
       "slips of a wheel a minute",
       {0.0, 1.0, 3.0, 10.0, 30.0},
       [](RoomStudy& study) -> double& { return study.world.wheels.slips_per_minute; }},
      {"gyro bias",
       "rad/s, sigma",
       {0.0, 0.01, 0.03, 0.1, 0.3},
       [](RoomStudy& study) -> double& { return study.world.gyro.bias_sigma; }},
      {"late odometry",
       "s",
       {0.0, 0.05, 0.1, 0.2, 0.4},
       [](RoomStudy& study) -> double& { return study.odometry_delay; }},
  };
}

PipelineOptions textbook(PipelineOptions options) {
  options.association.type = AssociationOptions::Type::kNearestNeighbor;
  options.estimator.robust_threshold = 0.0;
  options.life_cycle = LifeCycleOptions::none();
  return options;
}

std::vector<FaultSweep> run_robustness(const RoomStudy& base, const std::vector<Fault>& faults) {
  std::vector<FaultSweep> sweeps;
  for (const Fault& fault : faults) {
    RoomStudy study = base;
    FaultSweep sweep{fault, fault.strength_in(study), {}};
    for (const double strength : with_base(fault.strengths, sweep.base_strength)) {
      sweep.points.push_back({strength, {}, {}});
    }
    sweeps.push_back(std::move(sweep));
  }

  std::vector<Job> jobs;
  for (FaultSweep& sweep : sweeps) {
    for (RobustnessPoint& point : sweep.points) {
      RoomStudy study = base;
      sweep.fault.strength_in(study) = point.strength;
      jobs.push_back({study, &point.configured});
      study.pipeline = textbook(base.pipeline);
      jobs.push_back({study, &point.textbook});
    }
  }
  const auto seeds = static_cast<std::size_t>(base.seeds);
  std::vector<std::vector<RoomRun>> runs(jobs.size(), std::vector<RoomRun>(seeds));
  for_each_run(
      jobs.size() * seeds,
      [&](std::size_t i) {
        const std::size_t job = i / seeds;
        const std::size_t seed = i % seeds;
        runs[job][seed] = run_room(jobs[job].study, base.first_seed + seed);
      },
      base.on_progress);
  for (std::size_t job = 0; job < jobs.size(); ++job) *jobs[job].summary = summarize(runs[job]);
  return sweeps;
}

std::string to_table(const std::vector<FaultSweep>& sweeps) {
  std::string table;
  for (const FaultSweep& sweep : sweeps) {
    table += format("%s (%s); * the base point\n", sweep.fault.name, sweep.fault.unit) +
             format("%-11s%37s%41s\n", "", "configured", "textbook") + format("%-11s", "strength");
    for (const char* gap : {"", "    "}) {
      table += gap + format("%10s %8s %7s %9s", "success", "RMSE (m)", "worst", "too many");
    }
    table += "\n";
    for (const RobustnessPoint& point : sweep.points) {
      const char* mark = point.strength == sweep.base_strength ? "*" : "";
      table += format("%-11s", format("%g%s", point.strength, mark).c_str()) + figures(point.configured) +
               "    " + figures(point.textbook) + "\n";
    }
    table += "\n";
  }
  return table +
         "success: every landmark once, nothing else, aligned RMSE of the landmarks at most 0.09 m; RMSE: "
         "median "
         "of the runs\n";
}

std::string to_json(const std::vector<FaultSweep>& sweeps) {
  std::string text = "[\n";
  for (const FaultSweep& sweep : sweeps) {
    std::vector<double> strengths;
    for (const RobustnessPoint& point : sweep.points) strengths.push_back(point.strength);
    text += std::string(text.size() > 2 ? ",\n" : "") + "{\"fault\": \"" + sweep.fault.name +
            "\", \"unit\": \"" + sweep.fault.unit + "\", \"base\": " + number(sweep.base_strength) +
            ", \"runs\": " + std::to_string(sweep.points.front().configured.runs) +
            ", \"strength\": " + json(strengths) +
            ",\n \"configured\": " + to_json(sweep, &RobustnessPoint::configured) +
            ",\n \"textbook\": " + to_json(sweep, &RobustnessPoint::textbook) + "}";
  }
  return text + "\n]\n";
}

}  // namespace kinect_ekf_slam
