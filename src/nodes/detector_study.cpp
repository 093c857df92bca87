#include <cstdio>
#include <exception>
#include <string>

#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/picture_study.h"

namespace {

constexpr const char* kUsage =
    "usage: detector_study cylinders [--views N] [--seed N] [--palette FILE.yaml]\n"
    "\n"
    "Renders random views of a room as a Kinect takes them, runs the detector on each, and compares with "
    "the\n"
    "truth. A cylinder is expected when it is 0.6 to 2.6 m away, whole in the picture, and nothing hides a "
    "part.\n"
    "  --views N             default: 200\n"
    "  --seed N              of the first view; default: 1\n"
    "  --palette FILE.yaml   default: config/palette.yaml\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

}  // namespace

int main(int argc, char** argv) {
  constexpr int kMost = 1000000;
  kinect_ekf_slam::CommandLine words("detector_study", kUsage, argc, argv);
  kinect_ekf_slam::CylinderStudy study;
  std::string palette = "config/palette.yaml";
  std::string subject;
  while (words.next()) {
    if (words.word() == "--views") {
      study.views = words.number(1, kMost, "a whole number from 1 to 1000000");
    } else if (words.word() == "--seed") {
      study.first_seed = words.number(0, kMost, "a whole number from 0 to 1000000");
    } else if (words.word() == "--palette") {
      palette = words.value();
    } else if (words.is_option() || !subject.empty()) {
      words.fail_at_word("unknown option");
    } else {
      subject = words.word();
    }
  }
  if (subject != "cylinders") words.fail("'" + subject + "' given, allowed: cylinders; see --help");
  try {
    study.palette = kinect_ekf_slam::read_palette(palette);
    study.on_progress = kinect_ekf_slam::progress_bar();
    const kinect_ekf_slam::CylinderStudyResult result = kinect_ekf_slam::run_study(study);
    kinect_ekf_slam::clear_progress_bar();
    std::fputs(kinect_ekf_slam::to_table(result).c_str(), stdout);
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
