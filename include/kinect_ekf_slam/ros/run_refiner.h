#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/run_options.h"
#include "kinect_ekf_slam/ros/run_recorder.h"
#include "kinect_ekf_slam/ros/run_writer.h"

namespace kinect_ekf_slam {

/// What a refinement found, for the last lines of a tool.
struct RefinementReport {
  std::vector<std::string> calibration;  ///< one line an unknown
  std::vector<std::string> warnings;
  std::size_t sightings = 0;
  std::size_t doubted = 0;           ///< of them: outside the gate, so that they hardly count
  double path_difference = 0.0;      ///< m, RMS from the filter's
  double landmark_difference = 0.0;  ///< m, likewise
  double seconds = 0.0;
};

/// A filter's run that is over, with all that it was.
struct FinishedRun {
  const RunRecorder& recorder;
  const std::vector<RunWriter::AssociationRow>& associations;  ///< as known at the end
  std::vector<Landmark3d> map;
  RunWriter::Summary summary;
};

/// Throws std::runtime_error with one line where runs cannot be refined: this build, or these options.
void require_refining(const RunOptions& options);

/// Finds the batch optimum of a run and writes it to `directory` in the files of RunWriter, with
/// `calibration.yaml` (parameters for another run) and `refinement.json` (the calibration with its sigmas,
/// and how far the filter was). Throws std::runtime_error with one line when there is none.
RefinementReport refine_run(const FinishedRun& run, const RunOptions& options, const std::string& directory,
                            const std::function<void(double)>& on_progress);

}  // namespace kinect_ekf_slam
