#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/ros/bag_replay.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/configuration.h"
#include "kinect_ekf_slam/ros/parameters.h"

namespace {

constexpr const char* kUsage =
    "usage: slam_replay BAG [--config FILE.yaml] [--out DIR [--refine] [--global]] [--set group/key=value "
    "...]\n"
    "\n"
    "Runs a recorded bag through the SLAM pipeline as fast as it can, without a ROS master.\n"
    "  --config FILE.yaml      parameters that differ from config/slam.yaml; may be given more than once\n"
    "  --out DIR               write trajectory, landmarks, associations, the map, parameters and a summary\n"
    "                          there\n"
    "  --refine                also find the most probable path, map and calibration given the whole run, "
    "and\n"
    "                          write them to DIR/refined in the same files, with calibration.yaml and\n"
    "                          refinement.json\n"
    "  --global                also make local maps without the global positions, put all of them into the "
    "frame\n"
    "                          of those, and write path and map to DIR/global in the same files, with\n"
    "                          segments.csv\n"
    "  --set group/key=value   one parameter, over all files\n"
    "  --parameters            list all parameters as Markdown and exit\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  std::string bag;
  std::vector<std::string> configs;
  std::string output;
  bool refine = false;
  bool global = false;
  std::vector<std::string> settings;
};

void print_parameters() {
  std::printf("| parameter | default | unit | allowed | meaning |\n|---|---|---|---|---|\n");
  for (const kinect_ekf_slam::ParameterInfo& info : kinect_ekf_slam::list_parameters()) {
    std::printf("| `%s`%s | %s | %s | %s | %s |\n", info.key.c_str(), info.required ? " (required)" : "",
                info.default_value.empty() ? "\"\"" : info.default_value.c_str(), info.unit.c_str(),
                info.allowed.c_str(), info.meaning.c_str());
  }
}

void warn(const std::string& line) { std::fprintf(stderr, "slam_replay: warning: %s\n", line.c_str()); }

void print_refinement(const kinect_ekf_slam::RefinementReport& report, const std::string& output) {
  for (const std::string& line : report.warnings) warn(line);
  std::printf(
      "refined in %.1f s: %zu of %zu sightings doubted, the path %.3f m and the landmarks %.3f m (RMS) from "
      "the "
      "filter's; written to %s/refined\n",
      report.seconds, report.doubted, report.sightings, report.path_difference, report.landmark_difference,
      output.c_str());
  for (const std::string& line : report.calibration) std::printf("  %s\n", line.c_str());
}

void print_global(const kinect_ekf_slam::GlobalRunReport& report, const std::string& output) {
  for (const std::string& line : report.warnings) warn(line);
  std::printf(
      "global map in '%s': %zu of %zu stretches placed, made of %zu local maps, by %zu of %zu positions; %zu "
      "landmarks, %d found again in other local maps; written to %s/global\n",
      report.frame.c_str(), report.placed, report.segments, report.local_maps,
      report.positions - report.left_out, report.positions, report.landmarks, report.merged_landmarks,
      output.c_str());
}

Arguments parse(kinect_ekf_slam::CommandLine* words) {
  Arguments arguments;
  while (words->next()) {
    const std::string& word = words->word();
    if (word == "--parameters") {
      print_parameters();
      std::exit(0);
    } else if (word == "--config") {
      arguments.configs.push_back(words->value());
    } else if (word == "--out") {
      arguments.output = words->value();
    } else if (word == "--refine") {
      arguments.refine = true;
    } else if (word == "--global") {
      arguments.global = true;
    } else if (word == "--set") {
      const std::vector<std::string> settings = words->assignments();
      arguments.settings.insert(arguments.settings.end(), settings.begin(), settings.end());
    } else if (words->is_option()) {
      words->fail_at_word("unknown option");
    } else if (arguments.bag.empty()) {
      arguments.bag = word;
    } else {
      words->fail_at_word("one bag at a time");
    }
  }
  if (arguments.bag.empty()) words->fail("no bag given; see --help");
  if (arguments.output.empty()) {
    for (const auto& [is_given, option] :
         {std::pair(arguments.refine, "--refine"), std::pair(arguments.global, "--global")}) {
      if (is_given) words->fail(std::string(option) + ": needs a folder to write to, --out DIR");
    }
  }
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("slam_replay", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  try {
    kinect_ekf_slam::ReplayRequest request;
    request.bag = arguments.bag;
    request.output_directory = arguments.output;
    request.refine = arguments.refine;
    request.global = arguments.global;
    request.options = kinect_ekf_slam::read_run_options(arguments.configs, arguments.settings,
                                                        [&request](const std::string& line) {
                                                          warn(line);
                                                          request.warnings.push_back(line);
                                                        });
    request.on_progress = kinect_ekf_slam::progress_bar();
    const kinect_ekf_slam::ReplayReport report = kinect_ekf_slam::replay_bag(request);
    kinect_ekf_slam::clear_progress_bar();
    for (const std::string& line : report.warnings) warn(line);
    std::printf(
        "%.0f s of data in %.2f s (%.0f times real time): %zu landmarks from %zu detection messages%s%s\n",
        report.data_seconds, report.wall_seconds, report.data_seconds / report.wall_seconds, report.landmarks,
        report.detection_frames, arguments.output.empty() ? "" : "; written to ", arguments.output.c_str());
    if (report.refinement) print_refinement(*report.refinement, arguments.output);
    if (report.global) print_global(*report.global, arguments.output);
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
