#include "kinect_ekf_slam/ros/parameters.h"

#include <cmath>
#include <limits>
#include <sstream>

#include "kinect_ekf_slam/ros/parameter_visitor.h"

namespace kinect_ekf_slam {
namespace {

using Visitor = ParameterVisitor;

void visit(Visitor& v, FrameOptions& o) {
  v.frame("frames/map", &o.map, "frame of the map and of every estimate");
  v.frame("frames/odom", &o.odom, "frame of the odometry; header of the odometry messages");
  v.frame("frames/base", &o.base, "frame of the robot; child frame of the odometry messages");
  v.number("frames/tf_timeout", &o.tf_timeout, 0.0, 10.0, "s", "how long a sensor's transform is waited for");
  v.transforms("frames/static_transforms", &o.static_transforms,
               "mountings of sensors that nothing publishes on tf");
}

void visit(Visitor& v, SyncOptions& o) {
  v.text("sync/odometry_topic", &o.odometry_topic, false, "nav_msgs/Odometry");
  v.text("sync/imu_topic", &o.imu_topic, true, "sensor_msgs/Imu; empty: there is no IMU");
  v.text("sync/landmarks_topic", &o.landmarks_topic, false, "kinect_ekf_slam/LandmarkDetectionArray");
  v.number("sync/max_interval", &o.max_interval, 1e-3, 10.0, "s",
           "largest difference of stamps inside one triple of odometry, IMU and detections");
  v.integer("sync/queue_size", &o.queue_size, 1, 100000, "messages",
            "that wait for their partners, per topic");
  v.number("sync/detection_delay", &o.detection_delay, 0.0, 60.0, "s",
           "how late detections may come; odometry waits for them that long before it enters the estimate");
  v.number("sync/position_delay", &o.position_delay, 0.0, 60.0, "s",
           "likewise positions and ranges; once there have been any, the estimate waits for them that long");
  v.number("sync/future_tolerance", &o.future_tolerance, 0.0, 3600.0, "s",
           "a message stamped further ahead of the clock is refused");
  v.number("sync/time_jump", &o.time_jump, 0.0, 3600.0, "s",
           "time going back further than this starts a new run (a looped bag)");
}

void visit(Visitor& v, SyncOptions& sync, InputOptions& o) {
  v.number("input/max_linear_speed", &o.max_linear_speed, 1e-6, kInfinity, "m/s",
           "odometry beyond it is clamped");
  v.number("input/max_angular_speed", &o.max_angular_speed, 1e-6, kInfinity, "rad/s",
           "odometry and gyro beyond it are clamped");
  v.number("input/linear_scale", &o.linear_scale, 0.1, 10.0, "-", "true speed over the odometry's");
  v.number("input/angular_scale", &o.angular_scale, 0.1, 10.0, "-", "true turn rate over the odometry's");
  v.number("input/odometry_delay", &sync.odometry_delay, -5.0, 5.0, "s",
           "odometry stamped t is true at t + delay");
  v.choice<HeadingSource>("input/heading_source", &o.heading_source,
                          {{"gyrodometry_report", HeadingSource::kGyrodometryReport},
                           {"gyrodometry", HeadingSource::kGyrodometry},
                           {"odometry", HeadingSource::kOdometry},
                           {"imu", HeadingSource::kImu}},
                          "which sensor turns the robot: docs/theory.md, section 1");
  v.number(
      "input/heading_threshold_deg", &o.heading_threshold_deg, 0.0, 360.0, "deg",
      "gyrodometry: wheels and gyro differ when their rates do by more than this over the odometry's period");
  v.number("input/max_gyro_age", &o.max_gyro_age, 0.0, 10.0, "s", "an older gyro rate is not used");
  v.number("input/max_odometry_gap", &o.max_odometry_gap, 0.0, 60.0, "s",
           "a velocity holds no longer than this; after it the motion is unknown");
  v.boolean("input/estimate_gyro_bias", &o.estimate_gyro_bias, "while the robot stands");
  v.number("input/standing_speed", &o.standing_speed, 0.0, 1.0, "m/s, rad/s",
           "odometry at most this fast means that the robot stands");
  v.number("input/standing_time", &o.standing_time, 0.0, 3600.0, "s",
           "the robot has stood this long before its gyro's bias is learnt");
  v.number("input/gyro_bias_limit", &o.gyro_bias_limit, 0.0, 10.0, "rad/s",
           "a standing robot whose gyro turns faster is being pushed: no bias");
  v.number("input/gyro_bias_time", &o.gyro_bias_time, 0.1, 3600.0, "s", "time constant of the bias estimate");
}

void visit(Visitor& v, MotionOptions& o) {
  v.choice<MotionOptions::Noise>(
      "motion/noise", &o.noise,
      {{"report", MotionOptions::Noise::kReport}, {"proportional", MotionOptions::Noise::kProportional}},
      "report: covariance of the velocities, speed times gain, per step; proportional: variance that grows "
      "with time");
  v.number("motion/report_gain", &o.report_gain, 0.0, 100.0, "-", "gain of the preset report");
  v.number("motion/linear_noise", &o.linear_noise, 0.0, 10.0, "m/sqrt(s)", "forward, while moving");
  v.number("motion/linear_noise_per_speed", &o.linear_noise_per_speed, 0.0, 10.0, "sqrt(s)",
           "forward, per m/s of speed");
  v.number("motion/lateral_noise_per_speed", &o.lateral_noise_per_speed, 0.0, 10.0, "sqrt(s)",
           "sideways, per m/s of speed");
  v.number("motion/angular_noise", &o.angular_noise, 0.0, 10.0, "rad/sqrt(s)",
           "heading, while moving, where the wheels turn it");
  v.number("motion/angular_noise_per_rate", &o.angular_noise_per_rate, 0.0, 10.0, "sqrt(s)",
           "heading, per rad/s of turning");
  v.number("motion/angular_noise_per_speed", &o.angular_noise_per_speed, 0.0, 10.0, "rad sqrt(s)/m",
           "heading, per m/s of speed");
  v.number("motion/gyro_noise", &o.gyro_noise, 0.0, 10.0, "rad/sqrt(s)",
           "heading, while moving, where the gyro turns it");
  v.number("motion/gyro_noise_per_rate", &o.gyro_noise_per_rate, 0.0, 10.0, "sqrt(s)",
           "likewise, per rad/s of turning: its scale error");
}

void visit(Visitor& v, SensorOptions& o) {
  v.number("sensor/min_depth", &o.min_depth, -kInfinity, kInfinity, "m", "nearer detections are dropped");
  v.number("sensor/max_depth", &o.max_depth, 0.0, kInfinity, "m", "farther detections are dropped");
  v.number("sensor/max_lateral", &o.max_lateral, 0.0, kInfinity, "m", "detections further aside are dropped");
  v.number("sensor/range_scale", &o.range_scale, 0.1, 10.0, "-", "true distance over the measured one");
  v.number("sensor/depth_share", &o.depth_share, 0.0, 1.5, "-",
           "0: the measured distance is that to the landmark; 1: it is the depth, along the optical axis");
  v.integer("sensor/max_detections", &o.max_detections, 1, 10000, "detections",
            "of one message that are used; further ones are refused, so that no message stops the node");
  v.number("sensor/correlation_time", &o.correlation_time, 0.0, 1e4, "s",
           "over which the errors of one landmark's sightings resemble each other; 0: independent");
  v.choice<SensorOptions::NoiseSource>(
      "sensor/noise_source", &o.noise_source,
      {{"message", SensorOptions::NoiseSource::kMessage}, {"model", SensorOptions::NoiseSource::kModel}},
      "message: the detection's own covariance, the model where it has none; model: always the model");
  v.choice<SensorOptions::Model>("sensor/model", &o.model,
                                 {{"depth_quadratic", SensorOptions::Model::kDepthQuadratic},
                                  {"range_bearing", SensorOptions::Model::kRangeBearing}},
                                 "the sensor's noise: a Kinect's by depth, or along and across the ray");
  v.number("sensor/depth_a", &o.depth_a, -kInfinity, kInfinity, "-",
           "depth_quadratic: variance a Z^2 + b Z + c");
  v.number("sensor/depth_b", &o.depth_b, -kInfinity, kInfinity, "m", "depth_quadratic");
  v.number("sensor/depth_c", &o.depth_c, -kInfinity, kInfinity, "m^2", "depth_quadratic");
  v.number("sensor/range_noise", &o.range_noise, 0.0, 100.0, "m", "range_bearing: sigma of the range at 0 m");
  v.number("sensor/range_noise_per_meter", &o.range_noise_per_meter, 0.0, 10.0, "-",
           "range_bearing: its growth with distance");
  v.number("sensor/bearing_noise_deg", &o.bearing_noise_deg, 1e-6, 90.0, "deg",
           "range_bearing: sigma of the bearing");
  if (o.min_depth > o.max_depth) {
    throw ParameterError("sensor/min_depth: " + text_of(o.min_depth) +
                         " given, allowed: at most sensor/max_depth, " + text_of(o.max_depth));
  }
}

void visit(Visitor& v, EstimatorOptions& o, PipelineOptions& pipeline) {
  v.require("estimator/type");
  std::string estimators;
  Choices<EstimatorOptions::Type> types;
  for (const EstimatorName& estimator : kEstimators) {
    types.emplace_back(estimator.name, estimator.type);
    estimators += std::string(estimators.empty() ? "" : "; ") + estimator.name + ": " + estimator.meaning;
  }
  v.choice<EstimatorOptions::Type>("estimator/type", &o.type, types, estimators);
  v.choice<SpaceType>(
      "estimator/space", &pipeline.space,
      {{Planar::kName, SpaceType::kPlanar}, {Spatial::kName, SpaceType::kSpatial}},
      "planar: x, y and heading, landmarks on the floor; spatial: any attitude, landmarks at any height");
  v.number("estimator/robust_threshold", &o.robust_threshold, 0.0, kInfinity, "-",
           "an accepted sighting beyond this squared Mahalanobis distance pulls less; 0: never");
  v.integer("estimator/replace_after", &o.replace_after, 0, 1000, "sightings",
            "known identities: in a row that contradict a landmark place it anew; 0: never");
  v.integer("estimator/max_landmarks", &o.max_landmarks, 1, 1000000, "landmarks", "more are refused");
  v.integer("estimator/particles", &o.particles, 1, 100000, "particles", "FastSLAM");
  v.integer("estimator/draw_after", &o.draw_after, 1, 1000, "landmarks",
            "FastSLAM: seen before the pose is drawn; until then a particle is a Kalman filter of pose and "
            "those; 1: drawn at each sighting");
  v.number("estimator/resample_below", &o.resample_below, 0.0, 1.0, "-",
           "FastSLAM: resampled when a smaller share of the particles is effective");
  v.choice<EstimatorOptions::MotionTail>(
      "estimator/motion_tail", &o.motion_tail,
      {{"gaussian", EstimatorOptions::MotionTail::kGaussian},
       {"cauchy", EstimatorOptions::MotionTail::kCauchy}},
      "FastSLAM: errors of the motion; cauchy: now and then one of many sigma");
  v.integer("estimator/seed", &o.seed, 0, std::numeric_limits<int>::max(), "-",
            "FastSLAM: of the random numbers; the same seed gives the same result");
  v.number("estimator/active_radius", &o.active_radius, 0.0, kInfinity, "m",
           "compressed_ekf: landmarks this near the robot are filtered at every step, the others when the "
           "robot has moved on; more than the sensor sees, or it is slow");
  v.number("estimator/active_hysteresis", &o.active_hysteresis, 0.0, 1.0, "-",
           "compressed_ekf: share of active_radius by which the robot has moved on");
  InitialPoseOptions& start = pipeline.initial_pose;
  v.number("estimator/initial_x", &start.x, -1e6, 1e6, "m", "where the robot starts in the map");
  v.number("estimator/initial_y", &start.y, -1e6, 1e6, "m", "where the robot starts in the map");
  v.number("estimator/initial_z", &start.z, -1e6, 1e6, "m", "likewise; spatial only");
  v.number("estimator/initial_roll_deg", &start.roll_deg, -360.0, 360.0, "deg",
           "its attitude there, about fixed axes roll, pitch, yaw; spatial only");
  v.number("estimator/initial_pitch_deg", &start.pitch_deg, -360.0, 360.0, "deg", "likewise; spatial only");
  v.number("estimator/initial_yaw_deg", &start.yaw_deg, -360.0, 360.0, "deg", "its heading there");
  v.number("estimator/initial_position_sigma", &start.position_sigma, 1e-9, 1e3, "m",
           "how sure that is; never zero");
  v.number("estimator/initial_heading_sigma_deg", &start.heading_sigma_deg, 1e-9, 360.0, "deg",
           "likewise, in space about each axis; never zero");
}

void visit(Visitor& v, AssociationOptions& o) {
  v.require("association/type");
  v.choice<AssociationOptions::Type>(
      "association/type", &o.type,
      {{"known", AssociationOptions::Type::kKnown},
       {"nearest_neighbor", AssociationOptions::Type::kNearestNeighbor},
       {"jcbb", AssociationOptions::Type::kJointCompatibility},
       {"multi_hypothesis", AssociationOptions::Type::kMultiHypothesis}},
      "known: by the detection's id; nearest_neighbor: by Mahalanobis distance; jcbb: of all sightings of "
      "one "
      "time together; multi_hypothesis: several maps, until what is seen decides between them");
  v.number("association/gate_probability", &o.gate_probability, 1e-6, 1.0, "-",
           "share of true sightings that the gate lets through: 0.975 is alpha = 7.378 in the plane");
  v.number("association/new_landmark_probability", &o.new_landmark_probability, 1e-6, 1.0, "-",
           "nearest_neighbor, jcbb: a detection outside this gate of every landmark is a new one");
  v.number("association/new_landmark_distance", &o.new_landmark_distance, 0.0, kInfinity, "m",
           "a detection nearer than this to a landmark is never a new one, unless identities are known");
  v.integer("association/joint_work", &o.joint_work, 1, 10000000, "pairings",
            "jcbb: that one message may try; then the best so far is taken");
  v.number("association/clutter_density", &o.clutter_density, 1e-12, 1e6, "1/m^2",
           "multi_hypothesis: false detections of a look per area (in space 1/m^3)");
  v.number("association/new_landmark_density", &o.new_landmark_density, 1e-12, 1e6, "1/m^2",
           "multi_hypothesis: detections of unmapped landmarks of a look per area (in space 1/m^3)");
  v.integer("association/max_hypotheses", &o.max_hypotheses, 1, 1000, "maps",
            "multi_hypothesis: that are kept at a time");
  v.number("association/decide_after", &o.decide_after, 0.0, 3600.0, "s",
           "multi_hypothesis: what the likeliest one held so long ago is final");
  v.number("association/prune_width", &o.prune_width, 0.0, 1e3, "-",
           "multi_hypothesis: those so much less likely, as log ratio, are dropped");
  v.number("association/branch_width", &o.branch_width, 0.0, 1e3, "-",
           "multi_hypothesis: likewise, ways to explain one message");
  v.number("association/clutter_width", &o.clutter_width, 0.0, 1e3, "-",
           "multi_hypothesis: likewise, taking a detection for nothing");
  v.number("association/label_error", &o.label_error, 1e-6, 0.5, "-",
           "share of the labels that are misread; 0.5: labels are not compared");
  v.number("association/radius_sigma", &o.radius_sigma, 0.0, 100.0, "m",
           "of a detection's radius; 0: radii are not compared");
  v.number("association/descriptor_sigma", &o.descriptor_sigma, 0.0, kInfinity, "-",
           "length of the difference of two descriptors of one landmark; 0: they are not compared");
  if (o.type != AssociationOptions::Type::kMultiHypothesis &&
      o.new_landmark_probability < o.gate_probability) {
    throw ParameterError("association/new_landmark_probability: " + text_of(o.new_landmark_probability) +
                         " given, allowed: at least association/gate_probability, " +
                         text_of(o.gate_probability));
  }
  const bool by_gates = o.type == AssociationOptions::Type::kNearestNeighbor ||
                        o.type == AssociationOptions::Type::kJointCompatibility;
  if (by_gates && o.new_landmark_probability == 1.0) {
    throw ParameterError(
        "association/new_landmark_probability: 1 given, allowed: less than 1, or nothing is ever new");
  }
  if (o.type == AssociationOptions::Type::kMultiHypothesis && o.new_landmark_density <= o.clutter_density) {
    throw ParameterError("association/new_landmark_density: " + text_of(o.new_landmark_density) +
                         " given, allowed: more than association/clutter_density, " +
                         text_of(o.clutter_density) + ", or nothing is ever new");
  }
}

void visit(Visitor& v, LifeCycleOptions& o) {
  v.integer("map/confirm_sightings", &o.confirm_sightings, 1, 100000, "sightings",
            "a new landmark is provisional until so many agree; 1: never");
  v.number("map/confirm_motion", &o.confirm_motion, 0.0, 1e3, "m or rad",
           "that the robot has moved since the first of them");
  v.number("map/confirm_time", &o.confirm_time, 0.0, 1e3, "s",
           "that lie between the first of them and the last: an error that lasts a moment is no landmark");
  v.number("map/forget_after", &o.forget_after, 0.0, kInfinity, "s",
           "a provisional landmark not seen for so long is taken off");
  v.number("map/merge_distance", &o.merge_distance, 0.0, 1e3, "m",
           "landmarks nearer than this that may be one and are not seen together become one; 0: never");
  v.number("map/merge_probability", &o.merge_probability, 1e-6, 1.0, "-", "of the gate for their difference");
  v.integer("map/remove_after_visits", &o.remove_after_visits, 0, 1000, "visits",
            "a landmark that so many visits in a row should have shown and did not is taken off; 0: never");
  v.number("map/field_of_view_deg", &o.field_of_view_deg, 1.0, 360.0, "deg",
           "of the sensor about the robot's forward axis, for that");
  v.number("map/vertical_field_of_view_deg", &o.vertical_field_of_view_deg, 1.0, 180.0, "deg",
           "likewise, up and down; spatial only");
  v.number("map/view_range", &o.view_range, 0.0, kInfinity, "m", "likewise, how far it sees");
}

void visit(Visitor& v, FusionOptions& o, PositionOptions& positions) {
  v.text("fusion/frame", &o.frame, false,
         "frame of global positions and of GPS; where the map lies in it is found from the robot's way");
  v.text("fusion/positions_topic", &o.positions_topic, true,
         "geometry_msgs/PoseWithCovarianceStamped in frames/map or fusion/frame; empty: none");
  v.text("fusion/fix_topic", &o.fix_topic, true, "sensor_msgs/NavSatFix; empty: none");
  v.text("fusion/ranges_topic", &o.ranges_topic, true, "kinect_ekf_slam/BeaconRanges; empty: none");
  v.text("fusion/antenna_frame", &o.antenna_frame, true,
         "frame that the positions of fusion/positions_topic speak of; empty: frames/base");
  v.datum("fusion/datum", &o.datum,
          "where fusion/frame has its origin, at most 100 km away; x is east, y north there; first_fix: "
          "the first that the next one agrees with");
  v.number("fusion/fix_sigma", &o.fix_sigma, 0.0, 1e3, "m", "of a fix without covariance; 0: it is refused");
  v.number("fusion/gate_probability", &positions.gate_probability, 0.5, 1.0, "-",
           "share of the true positions and ranges that the gate lets through");
  v.number("fusion/correlation_time", &positions.correlation_time, 0.0, 1e4, "s",
           "over which the errors of positions resemble each other; 0: independent");
  v.number(
      "fusion/lost_after", &positions.lost_after, 0.0, 3600.0, "s",
      "positions or ranges that agree contradict the estimate so long before it is the one that is wrong");
  v.number("fusion/align_heading_sigma_deg", &positions.align_heading_sigma_deg, 0.1, 30.0, "deg",
           "the heading between map and fusion/frame is known so well before positions are used");
  v.beacons("fusion/beacons", &positions.beacons,
            "places in frames/map that fusion/ranges_topic measures to; estimated from there");
  v.stretches("fusion/withhold", &positions.withheld,
              "after the run's start: positions that are compared, but not used; for evaluations");
}

void visit(Visitor& v, GlobalMapOutput& o, GlobalMappingOptions& mapping) {
  v.boolean(
      "global_map/enabled", &o.enabled,
      "slam_node: publish ~global_map, local maps in the frame of global positions; slam_replay: --global");
  v.number("global_map/period", &o.period, 0.1, 3600.0, "s", "between two of them");
  LocalMapOptions& local = mapping.local_maps;
  v.integer("global_map/min_matches", &local.min_matches, 1, 100000, "landmarks",
            "a look that matches fewer does not hold the robot in the local map");
  v.number("global_map/gap_time", &local.gap_time, 0.0, kInfinity, "s",
           "without such a look end the local map");
  v.number("global_map/max_position_sigma", &local.max_position_sigma, 1e-3, kInfinity, "m",
           "of the pose in the local map: more ends it");
  v.number("global_map/max_turn_sigma_deg", &local.max_turn_sigma_deg, 0.1, 180.0, "deg", "likewise");
  v.number(
      "global_map/path_interval", &local.path_interval, 0.01, 3600.0, "s",
      "between the places of the robot that are kept in the local map, and between positions that are used");
  v.integer("global_map/max_path_points", &local.max_path_points, 4, 10000, "places",
            "more end the local map");
  GlobalMapOptions& integration = mapping.integration;
  v.number("global_map/gate_probability", &integration.alignment.gate_probability, 0.5, 1.0, "-",
           "share of the true positions that overlap with the path; the others are left out, and told");
  v.number("global_map/max_alignment_sigma_deg", &integration.alignment.max_turn_sigma_deg, 0.1, 90.0, "deg",
           "of how a local map is turned in the global frame: with more it is joined with its neighbour");
  v.number("global_map/merge_probability", &integration.merge_probability, 1e-6, 1.0, "-",
           "of the gate for the difference of two local maps' landmarks that are one");
  v.integer("global_map/max_places", &integration.max_places, 10, 100000, "places",
            "of the way that carry the global map: of a longer one every second, third ... of them");
  v.integer(
      "global_map/max_joined_points", &integration.max_joined_points, 4, 100000, "points",
      "landmarks and places of neighbours that are placed together; more stay where they are not known");
}

void visit(Visitor& v, MapOptions& o) {
  v.text("map/directory", &o.directory, false, "the only folder that maps are saved to and loaded from");
  v.text("map/file_name", &o.file_name, false, "used by the services when they name none");
  v.boolean("map/load_at_start", &o.load_at_start, "load map/file_name when the node starts");
  v.boolean("map/save_at_exit", &o.save_at_exit, "save map/file_name when the node stops");
  v.number("map/autosave_period", &o.autosave_period, 0.0, 86400.0, "s",
           "how often map/file_name is saved while the node runs, once there is a landmark; 0: never");
  constexpr double kShortestPeriod = 0.01;  // s; the node has more to do than to save
  if (o.autosave_period > 0.0 && o.autosave_period < kShortestPeriod) {
    throw ParameterError("map/autosave_period: " + text_of(o.autosave_period) +
                         " given, allowed: 0 or at least " + text_of(kShortestPeriod));
  }
}

void visit(Visitor& v, OutputOptions& o) {
  v.boolean("output/publish_tf", &o.publish_tf, "map -> odom");
  v.number("output/transform_tolerance", &o.transform_tolerance, 0.0, 10.0, "s",
           "how far ahead map -> odom is dated, so that consumers need not wait");
  v.number("output/correction_time", &o.correction_time, 0.0, 60.0, "s",
           "over which a correction of map -> odom is spread: 63 % after it, 95 % after three; 0: at once; "
           "~pose is not delayed");
  v.number("output/marker_sigmas", &o.marker_sigmas, 0.1, 10.0, "sigma", "size of the ellipses in RViz");
  v.number("output/marker_rate", &o.marker_rate, 0.1, 100.0, "Hz", "of markers, map and path");
  v.number("output/path_step", &o.path_step, 0.0, 100.0, "m", "distance between poses of the path");
  v.integer("output/path_length", &o.path_length, 1, 1000000, "poses", "older ones are dropped");
  v.number("output/trajectory_rate", &o.trajectory_rate, 0.0, 10000.0, "Hz",
           "of slam_replay's trajectory files, besides the frames with detections; 0: every frame");
  v.number("output/pose_sigma_warning", &o.pose_sigma_warning, 1e-6, kInfinity, "m",
           "diagnostics warn above this standard deviation of the position");
}

void visit(Visitor& v, RunOptions& o) {
  v.choice<Mode>("mode", &o.pipeline.mode, {{"slam", Mode::kSlam}, {"localization", Mode::kLocalization}},
                 "slam: map and localise; localization: a loaded map that is not changed");
  visit(v, o.frames);
  visit(v, o.sync);
  visit(v, o.sync, o.pipeline.input);
  visit(v, o.pipeline.motion);
  visit(v, o.pipeline.sensor);
  visit(v, o.pipeline.estimator, o.pipeline);
  visit(v, o.pipeline.association);
  visit(v, o.map);
  visit(v, o.pipeline.life_cycle);
  v.boolean("map/relocalize_when_lost", &o.pipeline.relocalize_when_lost,
            "localization: when most of what is seen is not in the map, look for the robot all over it");
  visit(v, o.fusion, o.pipeline.positions);
  visit(v, o.global_map, o.pipeline.global_mapping);
  visit(v, o.output);
  if (std::abs(o.sync.odometry_delay) > o.sync.detection_delay) {
    throw ParameterError("input/odometry_delay: " + text_of(o.sync.odometry_delay) +
                         " given, allowed: no more than sync/detection_delay, " +
                         text_of(o.sync.detection_delay));
  }
  const FrameOptions& frames = o.frames;
  if (frames.map == frames.odom || frames.map == frames.base || frames.odom == frames.base) {
    throw ParameterError("frames/map, frames/odom, frames/base: '" + frames.map + "', '" + frames.odom +
                         "', '" + frames.base + "' given, allowed: three different frames");
  }
  if (o.fusion.frame == frames.map) {
    throw ParameterError(
        "fusion/frame: '" + o.fusion.frame +
        "' given, allowed: another frame than frames/map; positions in that need no fusion/frame");
  }
}

}  // namespace

RunOptions read_parameters(const YAML::Node& yaml, std::vector<std::string>* unread) {
  RunOptions options;
  Visitor visitor(&yaml);
  visit(visitor, options);
  std::ostringstream text;
  text << yaml;
  options.text = text.str();
  if (unread != nullptr) *unread = visitor.unread();
  return options;
}

std::vector<ParameterInfo> list_parameters() {
  RunOptions options;
  Visitor visitor(nullptr);
  visit(visitor, options);
  return visitor.infos();
}

}  // namespace kinect_ekf_slam
