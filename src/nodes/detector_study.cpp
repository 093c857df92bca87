#include <cstdint>
#include <cstdio>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "kinect_ekf_slam/perception/debug_picture.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/study/cylinder_study.h"
#include "kinect_ekf_slam/study/fiducial_study.h"

namespace {

constexpr const char* kUsage =
    "usage: detector_study cylinders|fiducials [--views N] [--seed N] [--palette FILE.yaml] [--picture "
    "FILE.png]\n"
    "\n"
    "Renders random views as a Kinect takes them, runs a detector on each, and compares with the truth.\n"
    "  cylinders             among boxes, bowls, rolls and legs; one is expected to be found when it is 0.6 "
    "to\n"
    "                        2.6 m away, whole in the picture, and nothing hides a part\n"
    "  fiducials             ArUco 4X4_50 of 0.15 m, 0.5 to 2.5 m away, slanted by up to 60 degrees\n"
    "  --views N             default: 200 of cylinders, 1000 of fiducials\n"
    "  --seed N              of the first view; default: 1\n"
    "  --palette FILE.yaml   default: config/palette.yaml\n"
    "  --picture FILE.png    cylinders: only draw what is found in the first view, and what is refused, "
    "there\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  std::string subject;
  int views = 0;
  std::uint64_t seed = 1;
  std::string palette = "config/palette.yaml";
  std::string picture;
};

Arguments parse(kinect_ekf_slam::CommandLine* words) {
  constexpr int kMost = 1000000;
  Arguments arguments;
  while (words->next()) {
    if (words->word() == "--views") {
      arguments.views = words->number(1, kMost, "a whole number from 1 to 1000000");
    } else if (words->word() == "--seed") {
      arguments.seed = words->number<std::uint64_t>(0, kMost, "a whole number from 0 to 1000000");
    } else if (words->word() == "--palette") {
      arguments.palette = words->value();
    } else if (words->word() == "--picture") {
      arguments.picture = words->value();
    } else if (words->is_option() || !arguments.subject.empty()) {
      words->fail_at_word("unknown option");
    } else {
      arguments.subject = words->word();
    }
  }
  if (arguments.subject != "cylinders" && arguments.subject != "fiducials") {
    words->fail("'" + arguments.subject + "' given, allowed: cylinders, fiducials; see --help");
  }
  return arguments;
}

void study_cylinders(const Arguments& arguments) {
  kinect_ekf_slam::CylinderStudy study;
  if (arguments.views > 0) study.views = arguments.views;
  study.first_seed = arguments.seed;
  study.palette = kinect_ekf_slam::read_palette(arguments.palette);
  if (!arguments.picture.empty()) {
    const kinect_ekf_slam::RgbdPicture picture = kinect_ekf_slam::first_picture(study);
    const kinect_ekf_slam::KinectCylinderDetector detector(study.detector, study.palette);
    const cv::Mat drawn = kinect_ekf_slam::draw_findings(picture.colour, detector.detect(picture));
    if (!cv::imwrite(arguments.picture, drawn)) throw std::runtime_error("cannot write " + arguments.picture);
    return;
  }
  study.on_progress = kinect_ekf_slam::progress_bar();
  const kinect_ekf_slam::CylinderStudyResult result = kinect_ekf_slam::run_study(study);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(result).c_str(), stdout);
}

void study_fiducials(const Arguments& arguments) {
  kinect_ekf_slam::FiducialStudy study;
  if (arguments.views > 0) study.views = arguments.views;
  study.first_seed = arguments.seed;
  study.on_progress = kinect_ekf_slam::progress_bar();
  const kinect_ekf_slam::FiducialStudyResult result = kinect_ekf_slam::run_study(study);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(result).c_str(), stdout);
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("detector_study", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  try {
    if (arguments.subject == "cylinders") {
      study_cylinders(arguments);
    } else {
      study_fiducials(arguments);
    }
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
