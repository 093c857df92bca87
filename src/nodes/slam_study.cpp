#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/atomic_file.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/kidnapped_study.h"
#include "kinect_ekf_slam/ros/parameters.h"
#include "kinect_ekf_slam/ros/room_study.h"
#include "kinect_ekf_slam/simulation/world.h"

namespace {

constexpr const char* kUsage =
    "usage: slam_study room|kidnapped [--world FILE.yaml] [--seeds N] [--config FILE.yaml]\n"
    "                       [--set group/key=value ...] [--json FILE]\n"
    "\n"
    "Simulates one world with many seeds, runs each through the SLAM pipeline in memory, and compares with "
    "the\n"
    "truth.\n"
    "  room                    the robot maps the world\n"
    "  kidnapped               robots put down anywhere look for themselves in its map; not with --json\n"
    "  --world FILE.yaml       default: config/worlds/room.yaml\n"
    "  --seeds N               seeds 1 to N; default: 100\n"
    "  --config FILE.yaml      parameters that differ from config/slam.yaml; may be given more than once\n"
    "  --set group/key=value   one parameter, over all files\n"
    "  --json FILE             write the figures, also those of each seed, there\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

constexpr int kMostSeeds = 1000000;

struct Arguments {
  std::string subcommand;
  std::string world = "config/worlds/room.yaml";
  int seeds = 100;
  std::vector<std::string> configs;
  std::vector<std::string> settings;
  std::string json;
};

Arguments parse(kinect_ekf_slam::CommandLine* words) {
  Arguments arguments;
  while (words->next()) {
    const std::string& word = words->word();
    if (word == "--world") {
      arguments.world = words->value();
    } else if (word == "--seeds") {
      arguments.seeds =
          words->number(1, kMostSeeds, "a whole number from 1 to " + std::to_string(kMostSeeds));
    } else if (word == "--config") {
      arguments.configs.push_back(words->value());
    } else if (word == "--set") {
      const std::vector<std::string> settings = words->assignments();
      arguments.settings.insert(arguments.settings.end(), settings.begin(), settings.end());
    } else if (word == "--json") {
      arguments.json = words->value();
    } else if (words->is_option()) {
      words->fail_at_word("unknown option");
    } else if (arguments.subcommand.empty()) {
      arguments.subcommand = word;
    } else {
      words->fail_at_word("one study at a time");
    }
  }
  if (arguments.subcommand != "room" && arguments.subcommand != "kidnapped") {
    words->fail("'" + arguments.subcommand + "' given, allowed: room, kidnapped; see --help");
  }
  return arguments;
}

void lose_robots(const Arguments& arguments, const kinect_ekf_slam::RoomStudy& room) {
  kinect_ekf_slam::KidnappedStudy study;
  study.world = room.world;
  study.pipeline = room.pipeline;
  study.robots = arguments.seeds;
  study.on_progress = room.on_progress;
  for (const bool looks : {true, false}) {
    study.looks = looks;
    const auto runs = kinect_ekf_slam::run_study(study);
    kinect_ekf_slam::clear_progress_bar();
    const std::string title = looks ? "with labels and radii" : "without";
    std::fputs(kinect_ekf_slam::to_table(title, runs).c_str(), stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("slam_study", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  try {
    kinect_ekf_slam::RoomStudy study;
    study.world = kinect_ekf_slam::read_world(arguments.world);
    if (study.world.drive.waypoints_in_world.empty())
      words.fail(arguments.world + ": drive/waypoints: none to drive to");
    study.pipeline =
        kinect_ekf_slam::read_run_options(arguments.configs, arguments.settings, [](const std::string& line) {
          std::fprintf(stderr, "slam_study: warning: %s\n", line.c_str());
        }).pipeline;
    study.seeds = arguments.seeds;
    study.on_progress = kinect_ekf_slam::progress_bar();
    if (arguments.subcommand == "kidnapped") {
      lose_robots(arguments, study);
      return 0;
    }
    const std::vector<kinect_ekf_slam::RoomRun> runs = kinect_ekf_slam::run_study(study);
    const kinect_ekf_slam::RoomSummary summary = kinect_ekf_slam::summarize(runs);
    kinect_ekf_slam::clear_progress_bar();
    std::fputs(kinect_ekf_slam::to_table(summary).c_str(), stdout);
    if (!arguments.json.empty()) {
      kinect_ekf_slam::write_file_atomically(arguments.json, kinect_ekf_slam::to_json(summary, runs));
    }
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
