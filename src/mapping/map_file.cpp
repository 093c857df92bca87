#include "kinect_ekf_slam/mapping/map_file.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "kinect_ekf_slam/core/atomic_file.h"
#include "kinect_ekf_slam/core/bounded_file.h"
#include "kinect_ekf_slam/core/compatibility.h"
#include "kinect_ekf_slam/core/one_line.h"
#include "kinect_ekf_slam/core/space.h"
#include "kinect_ekf_slam/mapping/yaml_keys.h"

namespace kinect_ekf_slam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "kinect_ekf_slam map";
constexpr int kVersion = 1;
constexpr std::size_t kLongestKey = 1000;             // bytes; YAML wants a mark before a longer one
constexpr double kFarthest = 1e9;                     // m; nothing is mapped beyond
constexpr double kLeastSure = kFarthest * kFarthest;  // m^2
constexpr std::size_t kLargestFile = 1U << 30U;       // bytes; a larger one is no map of ours

/// The shortest text that reads back as the same number.
std::string exact(double value) {
  std::string text;
  append_number(&text, value);
  return text;
}

template <class Vector>
std::string flow(const Vector& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i > 0 ? ", " : "") + exact(values(i));
  return text + "]";
}

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw MapFileError(path + ": " + what);
}

void check_keys(const YAML::Node& map) {
  if (const std::string fault = repeated_key(map); !fault.empty()) throw MapFileError(fault);
}

double finite(const YAML::Node& node, const char* what) {
  const auto value = node.as<double>();
  if (!std::isfinite(value)) throw MapFileError(std::string(what) + " is not finite");
  return value;
}

Eigen::VectorXd numbers(const YAML::Node& node, Eigen::Index count, double limit, const char* what) {
  if (!node.IsSequence() || static_cast<Eigen::Index>(node.size()) != count) {
    throw MapFileError(std::string(what) + " should have " + std::to_string(count) + " numbers");
  }
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) values(i) = finite(node[i], what);
  if ((values.array().abs() > limit).any()) {
    throw MapFileError(std::string(what) + " is beyond " + exact(limit));
  }
  return values;
}

/// How many numbers of what a space's maps hold.
struct Layout {
  Eigen::Index pose_numbers;  ///< of the pose as it is written
  Eigen::Index pose_dim;      ///< of its error: rows of the covariance
  Eigen::Index point_dim;
  const char* pose_meaning;
};

Layout layout_of(const std::string& space) {
  if (space == Planar::kName) {
    return {Planar::kPoseNumbers, Planar::kPoseDim, Planar::kPointDim,
            "m and rad: x, y, heading of the robot when the map was saved"};
  }
  if (space == Spatial::kName) {
    return {Spatial::kPoseNumbers, Spatial::kPoseDim, Spatial::kPointDim,
            "m, then a quaternion: x, y, z, qx, qy, qz, qw of the robot when the map was saved"};
  }
  throw MapFileError("space '" + space + "' is not known, allowed: " + Planar::kName + ", " + Spatial::kName);
}

/// Throws unless the numbers of a spatial pose end in a quaternion: another length is no rotation.
void check_pose(const SavedState& state) {
  constexpr double kTolerance = 1e-6;
  if (state.space == Spatial::kName && !(std::abs(state.pose.tail<4>().norm() - 1.0) < kTolerance)) {
    throw MapFileError("the quaternion of its pose is not of length 1");
  }
}

LandmarkInfo landmark_info(const YAML::Node& node) {
  check_keys(node);
  LandmarkInfo info;
  info.id = node["id"].as<int>();
  info.source_id = node["source_id"].as<int>();
  info.radius = finite(node["radius"], "a radius");
  info.observations = node["observations"].as<std::uint32_t>();
  info.radius_observations = node["radius_observations"].as<std::uint32_t>();
  constexpr std::uint32_t kMost = 1U << 31U;
  if (info.radius < 0.0 || info.observations > kMost || info.radius_observations > kMost) {
    throw MapFileError("landmark " + std::to_string(info.id) + ": radius or observations cannot be");
  }
  const YAML::Node votes = node["label_votes"];
  if (!votes.IsMap())
    throw MapFileError("landmark " + std::to_string(info.id) + ": label_votes is not a map");
  check_keys(votes);
  for (const auto& vote : votes) {
    info.label_votes[vote.first.as<std::string>()] = vote.second.as<std::uint32_t>();
  }
  return info;
}

SavedState parse(const YAML::Node& root, const std::string& expected_frame) {
  check_keys(root);
  const auto frame = root["frame"].as<std::string>();
  if (frame != expected_frame) {
    throw MapFileError("its frame is '" + frame + "', frames/map is '" + expected_frame + "'");
  }
  SavedState state;
  state.space = root["space"].as<std::string>();
  const Layout layout = layout_of(state.space);
  state.stamp = root["stamp_ns"].as<TimeNs>();
  state.pose = numbers(root["pose"], layout.pose_numbers, kFarthest, "pose");
  check_pose(state);
  const YAML::Node landmarks = root["landmarks"];
  if (!landmarks.IsSequence()) throw MapFileError("landmarks is not a list");
  const auto count = static_cast<Eigen::Index>(landmarks.size());
  state.landmarks_in_map.resize(count, layout.point_dim);
  std::set<int> ids;
  for (Eigen::Index i = 0; i < count; ++i) {
    state.infos.push_back(landmark_info(landmarks[i]));
    state.landmarks_in_map.row(i) =
        numbers(landmarks[i]["position"], layout.point_dim, kFarthest, "a position").transpose();
    if (state.infos.back().id == kNoId || !ids.insert(state.infos.back().id).second) {
      throw MapFileError("landmark id " + std::to_string(state.infos.back().id) + " is none or used twice");
    }
  }
  const Eigen::Index size = layout.pose_dim + layout.point_dim * count;
  const YAML::Node rows = root["covariance_lower_triangle"];
  if (!rows.IsSequence() || static_cast<Eigen::Index>(rows.size()) != size) {
    throw MapFileError("covariance_lower_triangle should have " + std::to_string(size) + " rows");
  }
  state.covariance.setZero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    state.covariance.row(i).head(i + 1) =
        numbers(rows[i], i + 1, kLeastSure, "a row of the covariance").transpose();
  }
  state.covariance = state.covariance.selfadjointView<Eigen::Lower>();
  if (Eigen::LDLT<Eigen::MatrixXd> ldlt(state.covariance);
      ldlt.info() != Eigen::Success ||
      !(ldlt.vectorD().minCoeff() >= -1e-9 * (1.0 + ldlt.vectorD().maxCoeff()))) {
    throw MapFileError("its covariance is not positive semi-definite");
  }
  return state;
}

}  // namespace

MapDirectory::MapDirectory(const std::string& directory) : path_(directory) {
  if (path_ == "~" || path_.rfind("~/", 0) == 0) {
    const char* home = std::getenv("HOME");
    path_ = (home != nullptr ? home : ".") + path_.substr(1);
  }
}

std::string MapDirectory::resolve(const std::string& file_name) const {
  const std::string ending = ".yaml";
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  const bool is_plain = file_name.size() > ending.size() && file_name.front() != '.' &&
                        file_name.find_first_of("/\\") == std::string::npos &&
                        std::none_of(file_name.begin(), file_name.end(), is_control) &&
                        file_name.compare(file_name.size() - ending.size(), ending.size(), ending) == 0;
  if (!is_plain) {
    throw MapFileError("'" + one_line(file_name) +
                       "': a map's name is a plain file name that ends in .yaml, in " + path_);
  }
  const fs::path path = fs::path(path_) / file_name;
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) fail(path.string(), "is not a regular file");
  return path.string();
}

void write_map(const std::string& path, const std::string& frame, const SavedState& state,
               const std::string& parameters) {
  if (!state.covariance.allFinite() || !state.landmarks_in_map.allFinite() || !state.pose.allFinite()) {
    fail(path, "not written: the estimate is not finite");
  }
  std::string text = std::string("format: ") + kFormat + "\nversion: " + std::to_string(kVersion) +
                     "\nframe: " + quoted(frame) + "\nspace: " + state.space +
                     "\nstamp_ns: " + std::to_string(state.stamp) + "\n# " +
                     layout_of(state.space).pose_meaning + "\npose: " + flow(state.pose) +
                     "\n# m, in the frame above\nlandmarks:" + (state.infos.empty() ? " []" : "") + "\n";
  for (std::size_t i = 0; i < state.infos.size(); ++i) {
    const LandmarkInfo& info = state.infos[i];
    text += "- {id: " + std::to_string(info.id) + ", source_id: " + std::to_string(info.source_id) +
            ", position: " + flow(state.landmarks_in_map.row(static_cast<Eigen::Index>(i))) +
            ", radius: " + exact(info.radius) + ", observations: " + std::to_string(info.observations) +
            ", radius_observations: " + std::to_string(info.radius_observations) + ", label_votes: {";
    for (auto vote = info.label_votes.begin(); vote != info.label_votes.end(); ++vote) {
      const std::string label = quoted(vote->first);
      text += vote == info.label_votes.begin() ? "" : ", ";
      text += (label.size() > kLongestKey ? "? " : "") + label + ": " + std::to_string(vote->second);
    }
    text += "}}\n";
  }
  text += "# m^2, m rad, rad^2: pose first, then the landmarks in their order; row i has i + 1 numbers\n";
  text += "covariance_lower_triangle:\n";
  for (Eigen::Index i = 0; i < state.covariance.rows(); ++i) {
    text += "- " + flow(state.covariance.row(i).head(i + 1)) + "\n";
  }
  text += "# what the map was made with; for the reader only\nparameters: |2\n";
  for (std::size_t begin = 0; begin < parameters.size();) {
    const std::size_t end = std::min(parameters.find('\n', begin), parameters.size());
    text += "  " + parameters.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  if (text.size() > kLargestFile)
    fail(path, "not written: " + std::to_string(text.size()) + " bytes, allowed: no more than " +
                   std::to_string(kLargestFile));
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  try {
    write_file_atomically(path, text);
  } catch (const std::runtime_error& problem) {
    throw MapFileError(problem.what());
  }
}

SavedState read_map(const std::string& path, const std::string& expected_frame) {
  try {
    const YAML::Node root = YAML::Load(read_regular_file(path, kLargestFile));
    if (!root.IsMap() || !root["format"] || root["format"].as<std::string>() != kFormat) {
      fail(path, "not a map of kinect_ekf_slam");
    }
    const auto version = root["version"].as<int>();
    if (version > kVersion) {
      fail(path, "version " + std::to_string(version) + " is newer than this program's, " +
                     std::to_string(kVersion));
    }
    if (version < 1) fail(path, "version " + std::to_string(version) + " does not exist");
    return parse(root, expected_frame);
  } catch (const YAML::Exception& problem) {
    fail(path, std::string("damaged: ") + problem.what());
  } catch (const std::runtime_error& problem) {
    const std::string line = problem.what();
    throw MapFileError(line.rfind(path, 0) == 0 ? line : path + ": " + line);
  }
}

}  // namespace kinect_ekf_slam
