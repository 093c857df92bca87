#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "kinect_ekf_slam/ros/bag_replay.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/parameters.h"

namespace {

constexpr const char* kUsage =
    "usage: slam_replay BAG [--config FILE.yaml] [--out DIR] [--set group/key=value ...]\n"
    "\n"
    "Runs a recorded bag through the SLAM pipeline as fast as it can, without a ROS master.\n"
    "  --config FILE.yaml      parameters that differ from config/slam.yaml; may be given more than once\n"
    "  --out DIR               write trajectory, landmarks, associations, the map and a summary there\n"
    "  --set group/key=value   one parameter, over all files\n"
    "  --parameters            list all parameters as Markdown and exit\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  std::string bag;
  std::vector<std::string> configs;
  std::string output;
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
    request.options = kinect_ekf_slam::read_run_options(
        arguments.configs, arguments.settings,
        [](const std::string& line) { std::fprintf(stderr, "slam_replay: warning: %s\n", line.c_str()); });
    std::map<std::string, std::string> refusals;  // the first of each kind: others differ in their stamps
    request.on_warning = [&refusals](const std::string& line) {
      refusals.emplace(line.substr(0, line.find_first_of("0123456789")), line);
    };
    request.on_progress = kinect_ekf_slam::progress_bar();
    const kinect_ekf_slam::ReplayReport report = kinect_ekf_slam::replay_bag(request);
    kinect_ekf_slam::clear_progress_bar();
    if (report.detection_frames == 0) {
      std::fprintf(stderr,
                   "slam_replay: warning: no detections on '%s' (sync/landmarks_topic): odometry alone\n",
                   request.options.sync.landmarks_topic.c_str());
    }
    if (report.new_runs > 0) {
      std::fprintf(stderr,
                   "slam_replay: warning: time went back %zu times; the results are of the last run\n",
                   report.new_runs);
    }
    for (const auto& [kind, line] : refusals)
      std::fprintf(stderr, "slam_replay: warning: %s\n", line.c_str());
    for (const auto& [reason, count] : report.refusals) {
      std::fprintf(stderr, "slam_replay: warning: %llu messages refused, %s\n",
                   static_cast<unsigned long long>(count), reason.c_str());
    }
    std::printf(
        "%.0f s of data in %.2f s (%.0f times real time): %zu landmarks from %zu detection messages%s%s\n",
        report.data_seconds, report.wall_seconds, report.data_seconds / report.wall_seconds, report.landmarks,
        report.detection_frames, arguments.output.empty() ? "" : "; written to ", arguments.output.c_str());
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
