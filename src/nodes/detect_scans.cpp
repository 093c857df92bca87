#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "kinect_ekf_slam/perception/laser_cylinder.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/detector_messages.h"

namespace {

constexpr const char* kUsage =
    "usage: detect_scans IN.bag --out OUT.bag [--topic NAME] [--radius MIN MAX] [--range-sigma M]\n"
    "\n"
    "Looks for cylinders in the scans of a bag and writes what it finds in each of them to another one, as\n"
    "kinect_ekf_slam/LandmarkDetectionArray on /landmarks, at the times at which the scans were received.\n"
    "  --out OUT.bag    file to write\n"
    "  --topic NAME     sensor_msgs/LaserScan; default: /scan\n"
    "  --radius MIN MAX bounds of the cylinders' radius in m; default: 0.05 0.2\n"
    "  --range-sigma M  standard deviation of the scanner's ranges; default: 0.01\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  std::string in;
  std::string out;
  std::string topic = "/scan";
  kinect_ekf_slam::LaserCylinderOptions options;
};

Arguments parse(kinect_ekf_slam::CommandLine* words) {
  Arguments arguments;
  while (words->next()) {
    if (words->word() == "--out") {
      arguments.out = words->value();
    } else if (words->word() == "--topic") {
      arguments.topic = words->value();
    } else if (words->word() == "--radius") {
      auto& radius = arguments.options.radius;
      radius.min = words->number(1e-3, 10.0, "m, from 0.001 to 10");
      radius.max = words->number(radius.min + 1e-3, 10.0, "m, more than MIN, up to 10");
    } else if (words->word() == "--range-sigma") {
      arguments.options.range_sigma = words->number(1e-6, 1.0, "m, from 0.000001 to 1");
    } else if (words->is_option() || !arguments.in.empty()) {
      words->fail_at_word("unknown option");
    } else {
      arguments.in = words->word();
    }
  }
  if (arguments.in.empty()) words->fail("IN.bag: is missing; see --help");
  if (arguments.out.empty()) words->fail("--out: is missing; see --help");
  return arguments;
}

/// Returns why scans could not be used, as one line; empty: all could.
std::string detect(rosbag::View* view, const kinect_ekf_slam::LaserCylinderOptions& options,
                   rosbag::Bag* out) {
  std::size_t unusable = 0;
  std::string problem;
  for (const rosbag::MessageInstance& instance : *view) {
    const auto message = instance.instantiate<sensor_msgs::LaserScan>();
    if (!message) continue;  // another type on the same topic
    try {
      const auto findings = kinect_ekf_slam::find_cylinders(kinect_ekf_slam::to_scan(*message), options);
      out->write("/landmarks", instance.getTime(), kinect_ekf_slam::to_message(findings, message->header));
    } catch (const std::runtime_error& error) {
      ++unusable;
      problem = error.what();
    }
  }
  if (unusable == 0) return {};
  return std::to_string(unusable) + " of " + std::to_string(view->size()) +
         " scans could not be used; the last one: " + problem;
}

/// The file appears under its name only when it is complete.
void convert(const Arguments& arguments) {
  const std::string partial = arguments.out + ".active";  // as rosbag record names what is not complete
  const rosbag::Bag in(arguments.in, rosbag::bagmode::Read);
  rosbag::View view(in, rosbag::TopicQuery(arguments.topic));
  if (view.size() == 0) throw std::runtime_error("holds no scans on " + arguments.topic);
  if (!view.begin()->instantiate<sensor_msgs::LaserScan>()) {
    throw std::runtime_error(arguments.topic + " is no sensor_msgs/LaserScan");
  }
  rosbag::Bag out(partial, rosbag::bagmode::Write);
  const std::string problem = detect(&view, arguments.options, &out);
  out.close();
  if (!problem.empty()) std::fprintf(stderr, "detect_scans: warning: %s\n", problem.c_str());
  if (std::rename(partial.c_str(), arguments.out.c_str()) != 0) {
    throw std::runtime_error("cannot write " + arguments.out);
  }
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("detect_scans", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  try {
    convert(arguments);
  } catch (const std::exception& error) {
    words.fail(arguments.in + ": " + error.what());
  }
  return 0;
}
