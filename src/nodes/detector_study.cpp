#include <cstdint>
#include <cstdio>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "kinect_ekf_slam/perception/debug_picture.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/detector_options.h"
#include "kinect_ekf_slam/ros/package_files.h"
#include "kinect_ekf_slam/study/cylinder_study.h"
#include "kinect_ekf_slam/study/feature_study.h"
#include "kinect_ekf_slam/study/fiducial_study.h"

namespace {

constexpr const char* kUsage =
    "usage: detector_study cylinders|fiducials|features [--views N] [--seed N] [--palette FILE.yaml]\n"
    "                      [--world FILE.yaml] [--type NAME] [--picture FILE.png]\n"
    "\n"
    "Renders random views as a Kinect takes them, runs a detector on each, and compares with the truth.\n"
    "  cylinders             among boxes, bowls, rolls and legs; one is expected to be found when it is 0.6 "
    "to\n"
    "                        2.6 m away, whole in the picture, and nothing hides a part\n"
    "  fiducials             ArUco 4X4_50 of 0.15 m, 0.5 to 2.5 m away, slanted by up to 60 degrees\n"
    "  features              on the way of a robot through a world with patterns\n"
    "  --views N             default: 200 of cylinders, 1000 of fiducials, 150 of features\n"
    "  --seed N              of the first view; default: 1\n"
    "  --palette FILE.yaml   default: config/palette.yaml\n"
    "  --world FILE.yaml     features; default: config/worlds/room_textured.yaml\n"
    "  --type NAME           features: harris, sift, orb or akaze; default: orb\n"
    "  --picture FILE.png    draw what is found, and what is refused, there: cylinders, only in the first "
    "view;\n"
    "                        features, in the last one\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  std::string subject;
  int views = 0;
  std::uint64_t seed = 1;
  std::string palette = kinect_ekf_slam::package_file("config/palette.yaml");
  std::string world = kinect_ekf_slam::package_file("config/worlds/room_textured.yaml");
  std::string type = "orb";
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
    } else if (words->word() == "--world") {
      arguments.world = words->value();
    } else if (words->word() == "--type") {
      arguments.type = words->value();
    } else if (words->word() == "--picture") {
      arguments.picture = words->value();
    } else if (words->is_option() || !arguments.subject.empty()) {
      words->fail_at_word("unknown option");
    } else {
      arguments.subject = words->word();
    }
  }
  const std::string& subject = arguments.subject;
  if (subject != "cylinders" && subject != "fiducials" && subject != "features") {
    words->fail("'" + subject + "' given, allowed: cylinders, fiducials, features; see --help");
  }
  return arguments;
}

void write(const std::string& path, const cv::Mat& picture) {
  if (!cv::imwrite(path, picture)) throw std::runtime_error("cannot write " + path);
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
    write(arguments.picture, drawn);
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

void study_features(const Arguments& arguments) {
  kinect_ekf_slam::FeatureStudy study;
  YAML::Node yaml;
  yaml["features"]["type"] = arguments.type;
  study.detector = kinect_ekf_slam::read_detector_options(yaml, nullptr).features;
  study.world = kinect_ekf_slam::read_world(arguments.world);
  if (study.world.pictures.rate == 0.0) throw std::runtime_error(arguments.world + ": camera/rate: is zero");
  if (arguments.views > 0) study.pictures = arguments.views;
  study.seed = arguments.seed;
  study.on_progress = kinect_ekf_slam::progress_bar();
  const kinect_ekf_slam::FeatureStudyResult result = kinect_ekf_slam::run_study(study);
  kinect_ekf_slam::clear_progress_bar();
  std::fputs(kinect_ekf_slam::to_table(result).c_str(), stdout);
  if (arguments.picture.empty()) return;
  write(arguments.picture, kinect_ekf_slam::draw_findings(result.last_picture.colour, result.last_findings));
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("detector_study", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  try {
    if (arguments.subject == "cylinders") {
      study_cylinders(arguments);
    } else if (arguments.subject == "features") {
      study_features(arguments);
    } else {
      study_fiducials(arguments);
    }
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
