#pragma once

#include "kinect_ekf_slam/association/associator.h"
#include "kinect_ekf_slam/estimators/options.h"
#include "kinect_ekf_slam/fusion/global_map_options.h"
#include "kinect_ekf_slam/mapping/life_cycle_options.h"
#include "kinect_ekf_slam/mapping/local_map_options.h"
#include "kinect_ekf_slam/models/input_conditioner.h"
#include "kinect_ekf_slam/models/motion.h"
#include "kinect_ekf_slam/models/sensor_model.h"
#include "kinect_ekf_slam/pipeline/position_options.h"

namespace kinect_ekf_slam {

enum class Mode { kSlam, kLocalization };
enum class SpaceType { kPlanar, kSpatial };

/// Where the robot starts, and how sure that is. In the plane z, roll and pitch are not used.
struct InitialPoseOptions {
  double x = 0.0;  ///< m, in the map
  double y = 0.0;
  double z = 0.0;
  double roll_deg = 0.0;  ///< deg, fixed axes roll, pitch, yaw
  double pitch_deg = 0.0;
  double yaw_deg = 0.0;
  double position_sigma = 1e-3;    ///< m, each axis; never zero
  double heading_sigma_deg = 0.1;  ///< deg, about each axis; never zero
};

/// How several local maps become one in the frame of global positions.
struct GlobalMappingOptions {
  LocalMapOptions local_maps;
  GlobalMapOptions integration;  ///< its association is the pipeline's
};

/// Everything that one run of the pipeline depends on.
struct PipelineOptions {
  InputOptions input;
  MotionOptions motion;
  SensorOptions sensor;
  EstimatorOptions estimator;
  AssociationOptions association;
  LifeCycleOptions life_cycle;
  InitialPoseOptions initial_pose;
  PositionOptions positions;
  GlobalMappingOptions global_mapping;
  SpaceType space = SpaceType::kPlanar;
  Mode mode = Mode::kSlam;
  bool relocalize_when_lost =
      false;  ///< localisation only: look for the robot when what it sees is not there
};

}  // namespace kinect_ekf_slam
