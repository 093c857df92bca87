#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "kinect_ekf_slam/perception/kinect_cylinder.h"
#include "kinect_ekf_slam/ros/command_line.h"
#include "kinect_ekf_slam/ros/thread_time.h"

namespace {

constexpr const char* kUsage =
    "usage: detect_picture --palette FILE.yaml [--camera FX FY CX CY] COLOUR DEPTH [COLOUR DEPTH ...]\n"
    "\n"
    "Looks for cylinders in pictures and prints one line of JSON for each pair: the file, what was found (m, "
    "in\n"
    "the optical frame), what was refused and why, and the milliseconds that it took on one core.\n"
    "  COLOUR DEPTH         files: 8 bit colour, and registered depth as 16 bit millimetres\n"
    "  --palette FILE.yaml  the colours' names, for example config/palette.yaml\n"
    "  --camera FX FY CX CY of both pictures, in pixels; default: 525 525 319.5 239.5\n"
    "Exit: 0 done, 2 the input cannot be used (one line says why).\n";

struct Arguments {
  kinect_ekf_slam::PinholeCamera camera;
  std::string palette;
  std::vector<std::string> files;
};

Arguments parse(kinect_ekf_slam::CommandLine* words) {
  Arguments arguments;
  while (words->next()) {
    if (words->word() == "--palette") {
      arguments.palette = words->value();
    } else if (words->word() == "--camera") {
      kinect_ekf_slam::PinholeCamera& camera = arguments.camera;
      for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
        *value = words->number(1e-3, 1e6, "four numbers of pixels, positive");
      }
    } else if (words->is_option()) {
      words->fail_at_word("unknown option");
    } else {
      arguments.files.push_back(words->word());
    }
  }
  if (arguments.palette.empty()) words->fail("--palette: is missing; see --help");
  if (arguments.files.empty() || arguments.files.size() % 2 != 0) {
    words->fail("pairs of a colour and a depth picture are needed; see --help");
  }
  return arguments;
}

cv::Mat read_image(const std::string& path, int flags) {
  cv::Mat image;
  if (std::ifstream(path)) image = cv::imread(path, flags);  // imread has a say of its own on missing files
  if (image.empty()) throw kinect_ekf_slam::PictureError(path + ": cannot be read as a picture");
  return image;
}

void print(const kinect_ekf_slam::Finding& finding) {
  const auto& position = finding.position;
  std::printf(R"({"position": [%.5f, %.5f, %.5f], "covariance": [)", position.x(), position.y(),
              position.z());
  for (int i = 0; i < 9; ++i) std::printf("%s%.3e", i > 0 ? ", " : "", finding.covariance(i / 3, i % 3));
  std::printf(R"(], "radius": %.5f, "label": "%s", "score": %.3f})", finding.signature.radius,
              finding.signature.label.c_str(), finding.score);
}

void print(const kinect_ekf_slam::Refusal& refusal) {
  const auto& region = refusal.region;
  std::printf(R"({"reason": "%s", "region": [%d, %d, %d, %d]})", refusal.reason.c_str(), region.left,
              region.top, region.width, region.height);
}

template <class Item>
void print_list(const char* name, const std::vector<Item>& items) {
  std::printf(R"(, "%s": [)", name);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) std::printf(", ");
    print(items[i]);
  }
  std::printf("]");
}

void detect(const kinect_ekf_slam::KinectCylinderDetector& detector, const std::string& name,
            const kinect_ekf_slam::RgbdPicture& picture) {
  constexpr int kRepetitions = 5;  // the median counts
  kinect_ekf_slam::Findings findings;
  std::vector<double> milliseconds;
  for (int i = 0; i < kRepetitions; ++i) {
    const double start = kinect_ekf_slam::thread_seconds();
    findings = detector.detect(picture);
    milliseconds.push_back(1e3 * (kinect_ekf_slam::thread_seconds() - start));
  }
  std::nth_element(milliseconds.begin(), milliseconds.begin() + kRepetitions / 2, milliseconds.end());
  std::printf(R"({"file": "%s", "ms": %.3f)", name.c_str(), milliseconds[kRepetitions / 2]);
  print_list("found", findings.found);
  print_list("refused", findings.refused);
  std::printf("}\n");
}

}  // namespace

int main(int argc, char** argv) {
  kinect_ekf_slam::CommandLine words("detect_picture", kUsage, argc, argv);
  const Arguments arguments = parse(&words);
  cv::setNumThreads(1);
  try {
    const kinect_ekf_slam::KinectCylinderDetector detector({},
                                                           kinect_ekf_slam::read_palette(arguments.palette));
    for (std::size_t i = 0; i < arguments.files.size(); i += 2) {
      kinect_ekf_slam::RgbdPicture picture;
      picture.camera = arguments.camera;
      picture.colour = read_image(arguments.files[i], cv::IMREAD_COLOR);
      picture.depth = read_image(arguments.files[i + 1], cv::IMREAD_UNCHANGED);
      try {
        detect(detector, arguments.files[i], picture);
      } catch (const kinect_ekf_slam::PictureError& error) {
        words.fail(arguments.files[i] + ": " + error.what());
      }
    }
  } catch (const std::exception& error) {
    words.fail(error.what());
  }
  return 0;
}
