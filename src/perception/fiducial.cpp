#include "kinect_ekf_slam/perception/fiducial.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

namespace kinect_ekf_slam {
namespace {

using Corners = std::vector<cv::Point2f>;

const std::map<std::string, int>& dictionaries() {
  static const std::map<std::string, int> kDictionaries{{"4X4_50", cv::aruco::DICT_4X4_50},
                                                        {"4X4_100", cv::aruco::DICT_4X4_100},
                                                        {"4X4_250", cv::aruco::DICT_4X4_250},
                                                        {"4X4_1000", cv::aruco::DICT_4X4_1000},
                                                        {"5X5_50", cv::aruco::DICT_5X5_50},
                                                        {"5X5_100", cv::aruco::DICT_5X5_100},
                                                        {"5X5_250", cv::aruco::DICT_5X5_250},
                                                        {"5X5_1000", cv::aruco::DICT_5X5_1000},
                                                        {"6X6_50", cv::aruco::DICT_6X6_50},
                                                        {"6X6_100", cv::aruco::DICT_6X6_100},
                                                        {"6X6_250", cv::aruco::DICT_6X6_250},
                                                        {"6X6_1000", cv::aruco::DICT_6X6_1000},
                                                        {"ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL}};
  return kDictionaries;
}

int number_of(const std::string& dictionary) {
  const auto found = dictionaries().find(dictionary);
  if (found != dictionaries().end()) return found->second;
  std::string allowed;
  for (const auto& [name, number] : dictionaries()) allowed.append(allowed.empty() ? "" : ", ").append(name);
  throw std::invalid_argument("dictionary '" + dictionary + "' given, allowed: " + allowed);
}

/// The corners of a square of that side, as OpenCV orders them: from its upper left one clockwise.
std::vector<cv::Point3f> square(double side) {
  const auto half = static_cast<float>(0.5 * side);
  return {{-half, half, 0.0F}, {half, half, 0.0F}, {half, -half, 0.0F}, {-half, -half, 0.0F}};
}

cv::Mat matrix_of(const PinholeCamera& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0);
}

struct SquaresInPicture {
  std::vector<Corners> squares;
  std::vector<int> identities;
  std::vector<Corners> rejected;
};

/// Corners are where straight lines through the edges meet (Wang and Olson, "AprilTag 2", IROS 2016); in a
/// magnified picture, so that small fiducials have edges to fit lines to.
SquaresInPicture find_squares(const cv::Mat& picture, int dictionary) {
  constexpr double kMagnification = 2.0;
  cv::Mat magnified;
  cv::resize(picture, magnified, cv::Size(), kMagnification, kMagnification, cv::INTER_CUBIC);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_APRILTAG;
  parameters->errorCorrectionRate = 0.0;  // a corrected identity may be another's
  SquaresInPicture seen;
  cv::aruco::detectMarkers(magnified, cv::aruco::getPredefinedDictionary(dictionary), seen.squares,
                           seen.identities, parameters, seen.rejected);
  for (std::vector<Corners>* list : {&seen.squares, &seen.rejected}) {
    for (Corners& corners : *list) {
      for (cv::Point2f& corner : corners) {
        corner.x = static_cast<float>((corner.x + 0.5) / kMagnification - 0.5);
        corner.y = static_cast<float>((corner.y + 0.5) / kMagnification - 0.5);
      }
    }
  }
  return seen;
}

double shortest_edge(const Corners& corners) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    shortest = std::min(shortest, cv::norm(corners[i] - corners[(i + 1) % corners.size()]));
  }
  return shortest;
}

Region region_of(const Corners& corners) {
  const cv::Rect box = cv::boundingRect(corners);
  return {box.x, box.y, box.width, box.height};
}

/// How the corners' noise shows in the position, the rotation being unknown as well.
Eigen::Matrix3d position_covariance(const std::vector<cv::Point3f>& model, const cv::Vec3d& rotation,
                                    const cv::Vec3d& translation, const cv::Mat& camera,
                                    double corner_sigma) {
  std::vector<cv::Point2f> projected;
  cv::Mat jacobian;  // 8 x (3 of the rotation, 3 of the translation, ...)
  cv::projectPoints(model, rotation, translation, camera, cv::noArray(), projected, jacobian);
  Eigen::Matrix<double, 8, 6> by_pose;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 6; ++j) by_pose(i, j) = jacobian.at<double>(i, j);
  }
  const Eigen::Matrix<double, 6, 6> information =
      by_pose.transpose() * by_pose / (corner_sigma * corner_sigma);
  const Eigen::Matrix<double, 6, 3> selected = Eigen::Matrix<double, 6, 6>::Identity().rightCols<3>();
  const Eigen::Matrix3d covariance = information.ldlt().solve(selected).bottomRows<3>();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

FiducialDetector::FiducialDetector(const FiducialOptions& options)
    : options_(options), dictionary_(number_of(options.dictionary)) {}

Findings FiducialDetector::detect(const RgbdPicture& picture) const {
  check(picture);
  if (picture.colour.empty()) throw PictureError("no colour in the picture");
  const SquaresInPicture seen = find_squares(picture.colour, dictionary_);
  const std::vector<Corners>& squares = seen.squares;

  Findings findings;
  const std::vector<cv::Point3f> model = square(options_.side);
  const cv::Mat camera = matrix_of(picture.camera);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    cv::Vec3d rotation;
    cv::Vec3d translation;
    const bool is_big = shortest_edge(squares[i]) >= options_.min_side_pixels;
    if (!is_big || !cv::solvePnP(model, squares[i], camera, cv::noArray(), rotation, translation, false,
                                 cv::SOLVEPNP_IPPE_SQUARE)) {
      findings.refused.push_back(
          {is_big ? "no pose" : "too small to be read for sure", region_of(squares[i])});
      continue;
    }
    Finding finding;
    finding.position = Eigen::Vector3d(translation[0], translation[1], translation[2]);
    const double pointing = options_.pointing * finding.position.norm();
    finding.covariance = position_covariance(model, rotation, translation, camera, options_.corner_sigma) +
                         pointing * pointing * Eigen::Matrix3d::Identity();
    finding.signature.source_id = seen.identities[i];
    finding.signature.label = "aruco";
    finding.region = region_of(squares[i]);
    if (finding.position.allFinite() && finding.covariance.allFinite()) findings.found.push_back(finding);
  }
  for (const Corners& corners : seen.rejected)
    findings.refused.push_back({"no code of the dictionary", region_of(corners)});
  return findings;
}

std::vector<std::string> fiducial_pattern(const std::string& dictionary, int identity) {
  const auto codes = cv::aruco::getPredefinedDictionary(number_of(dictionary));
  if (identity < 0 || identity >= codes->bytesList.rows) {
    throw std::invalid_argument("fiducial " + std::to_string(identity) + " given, allowed: 0 to " +
                                std::to_string(codes->bytesList.rows - 1));
  }
  cv::Mat image;
  cv::aruco::drawMarker(codes, identity, codes->markerSize + 2, image, 1);
  std::vector<std::string> rows;
  for (int row = 0; row < image.rows; ++row) {
    rows.emplace_back();
    for (int column = 0; column < image.cols; ++column) {
      rows.back().push_back(image.at<std::uint8_t>(row, column) == 0 ? '#' : '.');
    }
  }
  return rows;
}

}  // namespace kinect_ekf_slam
