#include "kinect_ekf_slam/ros/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "kinect_ekf_slam/core/angles.h"

namespace kinect_ekf_slam {
namespace {

constexpr const char* kShareName = "sensor/depth_share";

std::string text_of(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof(buffer), format, value);
  return buffer;
}

CalibratedValue scale(const std::string& name, double configured, double log_scale, double sigma,
                      double prior_sigma) {
  const double value = configured * std::exp(log_scale);
  return {name, "", configured, value, value * sigma, configured * prior_sigma};
}

/// The parameter: on the sensor's axis, while the calibration's is that of the mean sighting.
template <class Space>
CalibratedValue range_scale(const BatchResult<Space>& result, double prior_sigma,
                            const SensorOptions& sensor) {
  static_assert(kDepthShare == kLogRangeScale + 1);
  const auto& unknowns = result.calibration.sensor;
  const double mean = 1.0 + unknowns(kDepthShare) * result.mean_obliquity;
  const double value = sensor.range_scale * std::exp(unknowns(kLogRangeScale)) *
                       (1.0 + sensor.depth_share * result.mean_obliquity) / mean;
  const Eigen::Vector2d by_unknowns(value, -value * result.mean_obliquity / mean);
  const Eigen::Matrix2d covariance = result.calibration_covariance.template block<2, 2>(
      kMotionUnknowns + kLogRangeScale, kMotionUnknowns + kLogRangeScale);
  return {"sensor/range_scale",
          "",
          sensor.range_scale,
          value,
          std::sqrt(by_unknowns.dot(covariance * by_unknowns)),
          sensor.range_scale * prior_sigma};
}

template <class Space>
CalibratedValue mounting(int axis, double value, double sigma, double prior_sigma) {
  const char* const names[] = {"sensor x",    "sensor y",     "sensor z",
                               "sensor roll", "sensor pitch", "sensor yaw"};
  const bool is_place = axis < Space::kPointDim;
  const double unit = is_place ? 1.0 : degrees(1.0);
  return {names[Space::kPoseAxes[axis]],
          is_place ? "m" : "deg",
          0.0,
          unit * value,
          unit * sigma,
          unit * prior_sigma,
          false};
}

/// A sensor cannot measure less than nothing of the depth, but an estimate may be a little below zero.
double allowed(const CalibratedValue& value) {
  return value.name == kShareName ? std::clamp(value.value, 0.0, 1.5) : value.value;
}

}  // namespace

template <class Space>
std::vector<CalibratedValue> calibrated_values(const BatchResult<Space>& result,
                                               const CalibrationPrior& prior, const RunOptions& options) {
  const Calibration<Space> priors = sigmas<Space>(prior);
  const Eigen::VectorXd found = result.calibration_covariance.diagonal().cwiseSqrt();
  const auto& motion = result.calibration.motion;
  const auto& unknowns = result.calibration.sensor;
  const InputOptions& input = options.pipeline.input;
  const SensorOptions& sensor = options.pipeline.sensor;
  const double delay = options.sync.odometry_delay;
  std::vector<CalibratedValue> values = {
      scale("input/linear_scale", input.linear_scale, motion(kLogLinearScale), found(kLogLinearScale),
            priors.motion(kLogLinearScale)),
      scale("input/angular_scale", input.angular_scale, motion(kLogAngularScale), found(kLogAngularScale),
            priors.motion(kLogAngularScale)),
      {"input/odometry_delay", "s", delay, delay + motion(kDelay), found(kDelay), priors.motion(kDelay)},
      range_scale(result, priors.sensor(kLogRangeScale), sensor),
      {kShareName, "", sensor.depth_share, unknowns(kDepthShare), found(kMotionUnknowns + kDepthShare),
       priors.sensor(kDepthShare)}};
  for (int i = 0; i < Space::kPoseDim; ++i) {
    values.push_back(mounting<Space>(i, unknowns(kMounting + i), found(kMotionUnknowns + kMounting + i),
                                     priors.sensor(kMounting + i)));
  }
  return values;
}

std::string calibration_line(const CalibratedValue& value) {
  return value.name + std::string(std::max<std::size_t>(22, value.name.size() + 1) - value.name.size(), ' ') +
         text_of("%9.4f", value.value) + text_of(" +- %.4f", value.sigma) + (value.unit.empty() ? "" : " ") +
         value.unit + text_of(", configured %g", value.configured) + text_of(" +- %.3g", value.prior_sigma);
}

std::string calibration_yaml(const std::vector<CalibratedValue>& values, const std::string& bag) {
  std::string text = "# Found by slam_replay --refine in " + bag +
                     ".\n# Parameters for other runs of this robot: a further --config, after the one that "
                     "this run had.\n";
  std::string group;
  std::string rest;
  for (const CalibratedValue& value : values) {
    if (!value.is_parameter) {
      rest += "#   " + calibration_line(value) + "\n";
      continue;
    }
    const std::size_t slash = value.name.find('/');
    if (value.name.substr(0, slash) != group) {
      group = value.name.substr(0, slash);
      text += group + ":\n";
    }
    text += "  " + value.name.substr(slash + 1) + ": " + text_of("%.6g", allowed(value)) + "  #";
    if (allowed(value) != value.value) text += text_of(" found %.2g", value.value);
    text += text_of(" +- %.2g", value.sigma) + (value.unit.empty() ? "" : " ") + value.unit + "\n";
  }
  return text +
         "# No parameters, but where the sensor stands besides what tf says, in the axes of the base:\n" +
         rest;
}

std::string calibration_json(const std::vector<CalibratedValue>& values) {
  std::ostringstream json;
  json.precision(9);
  json << "{";
  for (const CalibratedValue& value : values) {
    json << (&value == values.data() ? "" : ",") << "\n    \"" << value.name
         << "\": {\"value\": " << value.value << ", \"sigma\": " << value.sigma
         << ", \"configured\": " << value.configured << ", \"prior_sigma\": " << value.prior_sigma
         << ", \"unit\": \"" << value.unit << "\"}";
  }
  json << "\n  }";
  return json.str();
}

template std::vector<CalibratedValue> calibrated_values<Planar>(const BatchResult<Planar>&,
                                                                const CalibrationPrior&, const RunOptions&);
template std::vector<CalibratedValue> calibrated_values<Spatial>(const BatchResult<Spatial>&,
                                                                 const CalibrationPrior&, const RunOptions&);

}  // namespace kinect_ekf_slam
