#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/study/room_study.h"

namespace kinect_ekf_slam {

/// One thing that goes wrong, and how badly it is made to.
struct Fault {
  const char* name;
  const char* unit;
  std::vector<double> strengths;
  std::function<double&(RoomStudy&)> strength_in;  ///< where a study keeps it
};

/// Gross errors, false detections, missed detections, wrong labels, slip, gyro bias, late odometry.
std::vector<Fault> common_faults();

/// The pipeline with what a textbook does about association: nearest neighbour, every sighting believed.
PipelineOptions textbook(PipelineOptions options);

/// One fault at one strength, all others as in the study's base point.
struct RobustnessPoint {
  double strength = 0.0;
  RoomSummary configured;
  RoomSummary textbook;
};

struct FaultSweep {
  Fault fault;
  double base_strength = 0.0;
  std::vector<RobustnessPoint> points;  ///< in the order of their strengths; the base point is one of them
};

/// Makes one fault after the other weaker and stronger than in `base`, whose pipeline is the configured one.
/// All runs on all cores; every point sees the same seeds.
std::vector<FaultSweep> run_robustness(const RoomStudy& base, const std::vector<Fault>& faults);

/// For people, and the same figures for programs (scripts/plot_robustness.py).
std::string to_table(const std::vector<FaultSweep>& sweeps);
std::string to_json(const std::vector<FaultSweep>& sweeps);

}  // namespace kinect_ekf_slam
