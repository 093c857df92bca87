#pragma once

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/models/input_conditioner.h"
#include "kinect_ekf_slam/models/motion.h"
#include "kinect_ekf_slam/models/sensor_model.h"

namespace kinect_ekf_slam {

enum class Mode { kSlam, kLocalization };

/// Where the robot starts, and how sure that is.
struct InitialPoseOptions {
  double x = 0.0;                  ///< m, in the map
  double y = 0.0;                  ///< m
  double yaw_deg = 0.0;            ///< deg
  double position_sigma = 1e-3;    ///< m; never zero
  double heading_sigma_deg = 0.1;  ///< deg; never zero
};

/// Everything that one run of the pipeline depends on.
struct PipelineOptions {
  InputOptions input;
  MotionOptions motion;
  SensorOptions sensor;
  EstimatorOptions estimator;
  AssociationOptions association;
  InitialPoseOptions initial_pose;
  Mode mode = Mode::kSlam;
  bool relocalize_when_lost =
      false;  ///< localisation only: look for the robot when what it sees is not there
};

}  // namespace kinect_ekf_slam
