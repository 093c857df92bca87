#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/atomic_file.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/configuration.h"
#include "kinect_ekf_slam/ros/detector_options.h"
#include "kinect_ekf_slam/ros/package_files.h"
#include "kinect_ekf_slam/ros/parameters.h"
#include "kinect_ekf_slam/ros/picture_detector.h"
#include "kinect_ekf_slam/simulation/world.h"
#include "kinect_ekf_slam/study/consistency_study.h"
#include "kinect_ekf_slam/study/global_study.h"
#include "kinect_ekf_slam/study/kidnapped_study.h"
#include "kinect_ekf_slam/study/patrol_study.h"
#include "kinect_ekf_slam/study/robustness_study.h"
#include "kinect_ekf_slam/study/room_study.h"

namespace {

constexpr const char* kUsage =
    "usage: slam_study room [--world FILE.yaml] [--seeds N] [--first-seed N] [--config FILE.yaml]\n"
    "                       [--set group/key=value ...] [--json FILE]\n"
    "       slam_study chain [--detect group/key=value ...] [--picture-rate HZ] (as room)\n"
    "       slam_study robustness (as room)\n"
    "       slam_study kidnapped (as room, without --json)\n"
    "       slam_study patrol [--minutes N] (as room, without --seeds, --first-seed and --json)\n"
    "       slam_study consistency [--space planar|spatial] [--sensor kinect|far] [--seeds N] [--loops N]\n"
    "                       [--json FILE]\n"
    "       slam_study global [--seeds N] [--json FILE]\n"
    "\n"
    "room: simulates one world with many seeds, runs each through the SLAM pipeline in memory, and\n"
    "compares with the truth.\n"
    "chain: the same, but what is seen is what a detector finds in rendered pictures.\n"
    "robustness: as room, with one fault of the sensors after the other from none to gross, beside what a\n"
    "textbook's association makes of it.\n"
    "kidnapped: robots put down anywhere in the world look for themselves in its map.\n"
    "patrol: round and round in one world: do map, memory and time per update stay as they are?\n"
    "  --world FILE.yaml       default: config/worlds/room.yaml; robustness and patrol: room_hard.yaml\n"
    "  --config FILE.yaml      parameters that differ from config/slam.yaml; may be given more than once\n"
    "  --set group/key=value   one parameter, over all files\n"
    "  --first-seed N          the others follow it; default: 1\n"
    "  --detect group/key=value\n"
    "                          one parameter of landmark_detector_node, for example\n"
    "                          detector/type=features; default: those of config/detector.yaml and the\n"
    "                          labels of config/palette.yaml\n"
    "  --picture-rate HZ       default: the world's camera/rate, or 5\n"
    "  --minutes N             of simulated time; default: 60\n"
    "consistency: many loops with exactly the noise that the filters assume: do their covariances tell\n"
    "the truth?\n"
    "  --space                 default: planar\n"
    "  --sensor                kinect: 0.6 to 2.6 m, far: up to 5 m, both 57 degrees wide; default: kinect\n"
    "  --loops N               default: 10\n"
    "global: a robot that dives sees landmarks on parts of its way and hears buoys now and then: local "
    "maps,\n"
    "made one globally consistent map, beside what each sensor makes of it alone.\n"
    "All:\n"
    "  --seeds N               how many, each a run; default: 100, chain: 20, consistency and global: 50\n"
    "  --json FILE             write the figures, also those of each seed or time, there\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

constexpr int kMostSeeds = 1000000;
constexpr const char* kRoom = "config/worlds/room.yaml";  // of the package
constexpr const char* kHardRoom = "config/worlds/room_hard.yaml";

using kinect_ekf_slam::CommandLine;

int seed_count(CommandLine* words) {
  return words->number(1, kMostSeeds, "a whole number from 1 to " + std::to_string(kMostSeeds));
}

/// One of `choices`, which the present word of the command line must be followed by.
std::string choice(CommandLine* words, const std::vector<std::string>& choices) {
  const std::string option = words->word();
  std::string value = words->value();
  std::string allowed;
  for (const std::string& candidate : choices) {
    if (candidate == value) return value;
    allowed += (allowed.empty() ? "" : ", ") + candidate;
  }
  words->fail(option + ": '" + value + "' given, allowed: " + allowed);
}

/// The file that belongs to the present word, which can be written: to be known before the study, not after
/// it.
std::string output_file(CommandLine* words) {
  std::string path = words->value();
  kinect_ekf_slam::require_writable(path);
  return path;
}

void write(const std::string& path, const std::string& json) {
  if (!path.empty()) kinect_ekf_slam::write_file_atomically(path, json);
}

void append(const std::vector<std::string>& more, std::vector<std::string>* list) {
  list->insert(list->end(), more.begin(), more.end());
}

/// A study of a simulated room, and where its figures go.
struct RoomRequest {
  kinect_ekf_slam::RoomStudy study;
  std::string json;
  std::vector<std::string> detect;  ///< assignments to the detector's parameters
  double picture_rate = 0.0;        ///< Hz; 0: the world's
  int minutes = 60;
};

/// `own`: the options of this study besides --world, --config and --set, which every one has.
RoomRequest parse_room(CommandLine* words, const std::vector<std::string>& own,
                       const std::string& default_world = kRoom, int seeds = 100) {
  RoomRequest request;
  std::string world = kinect_ekf_slam::package_file(default_world);
  std::vector<std::string> configs;
  std::vector<std::string> settings;
  request.study.seeds = seeds;
  while (words->next()) {
    const std::string& word = words->word();
    const auto is_own = [&](const char* option) {
      return word == option && std::find(own.begin(), own.end(), word) != own.end();
    };
    if (word == "--world") {
      world = words->value();
    } else if (word == "--config") {
      configs.push_back(words->value());
    } else if (word == "--set") {
      append(words->assignments(), &settings);
    } else if (is_own("--seeds")) {
      request.study.seeds = seed_count(words);
    } else if (is_own("--first-seed")) {
      request.study.first_seed = words->number<std::uint64_t>(
          0, kMostSeeds, "a whole number from 0 to " + std::to_string(kMostSeeds));
    } else if (is_own("--json")) {
      request.json = output_file(words);
    } else if (is_own("--detect")) {
      append(words->assignments(), &request.detect);
    } else if (is_own("--picture-rate")) {
      request.picture_rate = words->number(0.1, 1000.0, "Hz, from 0.1 to 1000");
    } else if (is_own("--minutes")) {
      request.minutes = words->number(1, 100000, "a whole number from 1 to 100000");
    } else {
      words->fail_at_word("not an option of this study");
    }
  }
  request.study.world = kinect_ekf_slam::read_world(world);
  if (request.study.world.drive.waypoints_in_world.empty())
    words->fail(world + ": drive/waypoints: none to drive to");
  request.study.pipeline = kinect_ekf_slam::read_run_options(configs, settings, [](const std::string& line) {
                             std::fprintf(stderr, "slam_study: warning: %s\n", line.c_str());
                           }).pipeline;
  if (request.study.pipeline.mode == kinect_ekf_slam::Mode::kLocalization) {
    words->fail("mode: localization needs a map, and a study has none; allowed: slam");
  }
  request.study.on_progress = kinect_ekf_slam::progress_bar();
  return request;
}

void run(const RoomRequest& request) {
  const std::vector<kinect_ekf_slam::RoomRun> runs = kinect_ekf_slam::run_study(request.study);
  const kinect_ekf_slam::RoomSummary summary = kinect_ekf_slam::summarize(runs);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(summary).c_str(), stdout);
  write(request.json, kinect_ekf_slam::to_json(summary, runs));
}

void study_room(CommandLine* words) { run(parse_room(words, {"--seeds", "--first-seed", "--json"})); }

kinect_ekf_slam::DetectorOptions detector_options(const std::vector<std::string>& assignments) {
  YAML::Node yaml = YAML::LoadFile(kinect_ekf_slam::package_file("config/detector.yaml"));
  for (const std::string& assignment : assignments) kinect_ekf_slam::set_parameter(assignment, &yaml);
  std::vector<std::string> unread;
  auto options = kinect_ekf_slam::read_detector_options(yaml, &unread);
  for (const std::string& line : unread) throw kinect_ekf_slam::ParameterError(line);
  if (options.palette.empty()) options.palette = kinect_ekf_slam::package_file("config/palette.yaml");
  return options;
}

/// From pictures to the map.
void study_chain(CommandLine* words) {
  RoomRequest request =
      parse_room(words, {"--seeds", "--first-seed", "--json", "--detect", "--picture-rate"}, kRoom, 20);
  constexpr double kUsualRate = 5.0;  // Hz
  double& rate = request.study.world.pictures.rate;
  if (request.picture_rate > 0.0) rate = request.picture_rate;
  if (rate == 0.0) rate = kUsualRate;
  const kinect_ekf_slam::DetectorOptions options = detector_options(request.detect);
  request.study.make_detector = [&options] {
    const auto detector = std::make_shared<kinect_ekf_slam::PictureDetector>(options);
    return [detector](const kinect_ekf_slam::RgbdPicture& picture, const Eigen::Vector3d& up_in_optical) {
      return detector->detect(picture, up_in_optical);
    };
  };
  run(request);
}

void study_robustness(CommandLine* words) {
  const RoomRequest request = parse_room(words, {"--seeds", "--first-seed", "--json"}, kHardRoom);
  const auto sweeps = kinect_ekf_slam::run_robustness(request.study, kinect_ekf_slam::common_faults());
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(sweeps).c_str(), stdout);
  write(request.json, kinect_ekf_slam::to_json(sweeps));
}

void study_patrol(CommandLine* words) {
  const RoomRequest request = parse_room(words, {"--minutes"}, kHardRoom);
  kinect_ekf_slam::PatrolStudy study;
  study.world = request.study.world;
  study.pipeline = request.study.pipeline;
  study.minutes = request.minutes;
  study.on_progress = request.study.on_progress;
  const auto patrol = kinect_ekf_slam::run_study(study);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(patrol).c_str(), stdout);
}

void study_kidnapped(CommandLine* words) {
  const RoomRequest request = parse_room(words, {"--seeds", "--first-seed"});
  if (request.study.world.is_spatial()) words->fail("kidnapped: the world must be a planar one");
  kinect_ekf_slam::KidnappedStudy study;
  study.world = request.study.world;
  study.pipeline = request.study.pipeline;
  study.robots = request.study.seeds;
  study.first_seed = request.study.first_seed;
  study.on_progress = request.study.on_progress;
  for (const bool looks : {true, false}) {
    study.looks = looks;
    const auto runs = kinect_ekf_slam::run_study(study);
    kinect_ekf_slam::clear_progress_bar();
    std::fputs(kinect_ekf_slam::to_table(looks ? "with labels and radii" : "without", runs).c_str(), stdout);
  }
}

void study_consistency(CommandLine* words) {
  using Type = kinect_ekf_slam::EstimatorOptions::Type;
  kinect_ekf_slam::ConsistencyScenario scenario;
  std::string space = kinect_ekf_slam::Planar::kName;
  std::string json;
  int seeds = 50;
  while (words->next()) {
    const std::string& word = words->word();
    if (word == "--space") {
      space = choice(words, {kinect_ekf_slam::Planar::kName, kinect_ekf_slam::Spatial::kName});
    } else if (word == "--sensor") {
      if (choice(words, {"kinect", "far"}) == "far") {
        scenario.sensor.min_depth = 0.1;
        scenario.sensor.max_depth = scenario.sensor.max_lateral = 5.0;
      }
    } else if (word == "--seeds") {
      seeds = seed_count(words);
    } else if (word == "--loops") {
      scenario.loops = words->number(1, 1000, "a whole number from 1 to 1000");
    } else if (word == "--json") {
      json = output_file(words);
    } else {
      words->fail_at_word("unknown option of consistency");
    }
  }
  const std::vector<Type> estimators = {Type::kEkf, Type::kInvariantEkf, Type::kUkf};
  const auto progress = kinect_ekf_slam::progress_bar();
  const auto results =
      space == kinect_ekf_slam::Planar::kName
          ? kinect_ekf_slam::run_consistency<kinect_ekf_slam::Planar>(scenario, estimators, seeds, progress)
          : kinect_ekf_slam::run_consistency<kinect_ekf_slam::Spatial>(scenario, estimators, seeds, progress);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(results).c_str(), stdout);
  write(json, kinect_ekf_slam::to_json(results));
}

void study_global(CommandLine* words) {
  kinect_ekf_slam::GlobalStudy study;
  std::string json;
  while (words->next()) {
    if (words->word() == "--seeds") {
      study.seeds = seed_count(words);
    } else if (words->word() == "--json") {
      json = output_file(words);
    } else {
      words->fail_at_word("unknown option of global");
    }
  }
  study.on_progress = kinect_ekf_slam::progress_bar();
  kinect_ekf_slam::GlobalExample example;
  const kinect_ekf_slam::GlobalSummary summary = kinect_ekf_slam::run_study(study, &example);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(summary).c_str(), stdout);
  write(json, kinect_ekf_slam::to_json(summary, example));
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine words("slam_study", kUsage, argc, argv);
  try {
    const std::string study = words.next() ? words.word() : "";
    const std::map<std::string, void (*)(CommandLine*)> studies = {
        {"room", study_room},           {"chain", study_chain},   {"robustness", study_robustness},
        {"kidnapped", study_kidnapped}, {"patrol", study_patrol}, {"consistency", study_consistency},
        {"global", study_global}};
    const auto chosen = studies.find(study);
    if (chosen == studies.end()) {
      words.fail(
          "'" + study +
          "' given, allowed: room, chain, robustness, kidnapped, patrol, consistency, global; see --help");
    }
    chosen->second(&words);
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
