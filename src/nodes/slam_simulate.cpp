#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <exception>
#include <limits>
#include <string>

#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/simulation_bag.h"

namespace {

constexpr const char* kUsage =
    "usage: slam_simulate --world FILE.yaml --out BAG [--seed N] [--duration S]\n"
    "\n"
    "Simulates a robot in a world and writes what it would have recorded, and the truth, to a bag: odom, "
    "imu,\n"
    "landmarks, tf, tf_static, ground_truth/pose and ground_truth/landmarks (in world coordinates), and the "
    "pictures\n"
    "of the world's camera where its rate is not zero. The same world and seed give the same bytes.\n"
    "  --world FILE.yaml   for example config/worlds/room.yaml\n"
    "  --out BAG           file to write\n"
    "  --seed N            of all random numbers; default: 1\n"
    "  --duration S        seconds; default: until the robot has stood at its last waypoint for a second\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  std::string world;
  std::string bag;
  std::uint64_t seed = 1;
  double duration = 0.0;
};

Arguments parse(kinect_ekf_slam::CommandLine* words) {
  constexpr double kShortest = 1e-3;
  constexpr double kLongest = 1e6;
  Arguments arguments;
  while (words->next()) {
    const std::string& word = words->word();
    if (word == "--world") {
      arguments.world = words->value();
    } else if (word == "--out") {
      arguments.bag = words->value();
    } else if (word == "--seed") {
      arguments.seed = words->number<std::uint64_t>(0, std::numeric_limits<std::uint64_t>::max(),
                                                    "a whole number, not negative");
    } else if (word == "--duration") {
      arguments.duration = words->number(kShortest, kLongest, "seconds, from 0.001 to 1000000");
    } else {
      words->fail_at_word("unknown option");
    }
  }
  if (arguments.world.empty()) words->fail("--world: is missing; see --help");
  if (arguments.bag.empty()) words->fail("--out: is missing; see --help");
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("slam_simulate", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  try {
    kinect_ekf_slam::SimulationBagRequest request;
    request.world = kinect_ekf_slam::read_world(arguments.world);
    request.seed = arguments.seed;
    request.bag = arguments.bag;
    request.duration = arguments.duration;
    if (request.duration == 0.0 && request.world.drive.waypoints_in_world.empty()) {
      words.fail("--duration: is missing, and " + arguments.world +
                 " has no waypoints that would end the run");
    }
    const bool terminal = isatty(STDERR_FILENO) != 0;
    if (terminal) {
      request.on_progress = [](double seconds) { std::fprintf(stderr, "\r%7.1f s simulated", seconds); };
    }
    const double seconds = kinect_ekf_slam::write_simulation_bag(request);
    if (terminal) std::fprintf(stderr, "\r%30s\r", "");
    std::printf("%.1f s of %s, seed %llu, written to %s\n", seconds, arguments.world.c_str(),
                static_cast<unsigned long long>(arguments.seed), arguments.bag.c_str());
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
