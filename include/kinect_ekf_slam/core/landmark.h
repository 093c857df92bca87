#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "kinect_ekf_slam/core/time.h"

namespace kinect_ekf_slam {

constexpr int kNoId = -1;

/// What a detector says of a landmark besides its place.
struct Signature {
  int source_id = kNoId;  ///< identity that the detector read, kNoId: none
  std::string label;      ///< class or colour, empty: unknown
  double radius = 0.0;    ///< m, 0: unknown
  std::vector<float> descriptor;
};

/// One sighting, in the robot's base frame, with the view of the sensor that it came from.
struct Detection {
  Eigen::Vector3d position_in_base = Eigen::Vector3d::Zero();       ///< m
  Eigen::Matrix3d covariance_in_base = Eigen::Matrix3d::Zero();     ///< m^2; all zero: use the sensor model
  Eigen::Vector3d position_in_optical = Eigen::Vector3d::UnitZ();   ///< m; X right, Y down, Z forward (depth)
  Eigen::Matrix3d base_from_optical = Eigen::Matrix3d::Identity();  ///< rotation only
  Signature signature;
  double score = 1.0;
};

/// What is known of a mapped landmark besides its place.
struct LandmarkInfo {
  int id = kNoId;         ///< stable; the identity where it is known, else the map's own number
  int source_id = kNoId;  ///< identity as the detector reads it
  double radius = 0.0;    ///< m, mean of the sightings that told one, 0: unknown
  std::uint32_t observations = 0;
  std::uint32_t radius_observations = 0;
  TimeNs last_seen = 0;  ///< time of the last sighting that entered the estimate, 0: in this run none has
  std::map<std::string, std::uint32_t> label_votes;
  std::vector<float> descriptor;  ///< of the last sighting that told one; maps on file do not keep it
  bool confirmed = true;          ///< false: it may yet turn out that nothing is there

  /// The label that most sightings agree on; empty: none told one.
  std::string label() const;
  /// Takes in what one more sighting says.
  void add(TimeNs stamp, const Signature& signature);
  /// Takes in what another one knows that turned out to be the same landmark.
  void absorb(const LandmarkInfo& other);
};

/// What became of a detection. All but the first two are reasons why it did not enter the estimate.
enum class Verdict {
  kMatched,
  kCreated,
  kOutOfRange,         ///< outside the range gate of the sensor
  kOutsideGate,        ///< too far from the landmark that it should be
  kAmbiguous,          ///< too far to match, too near to be new
  kNoIdentity,         ///< association by identity, and the detection has none
  kDuplicateIdentity,  ///< a better detection of the same frame has the identity or landmark
  kSingular,           ///< innovation covariance not positive definite
  kInvalid,            ///< not finite, or no covariance
  kNotInMap,           ///< localisation only: no landmark of the map fits
  kMapFull,            ///< map/max_landmarks reached
  kLate,               ///< older than what the estimate already holds
  kClutter,            ///< taken for nothing that stands there
  kTooMany,            ///< the message had sensor/max_detections usable ones before it
};
constexpr int kVerdictCount = static_cast<int>(Verdict::kTooMany) + 1;

/// The verdict's name in messages, files and documents: lower case, words joined by `_`.
const char* to_string(Verdict verdict);

constexpr bool is_accepted(Verdict verdict) {
  return verdict == Verdict::kMatched || verdict == Verdict::kCreated;
}

}  // namespace kinect_ekf_slam
