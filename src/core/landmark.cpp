#include "kinect_ekf_slam/core/landmark.h"

#include <algorithm>

namespace kinect_ekf_slam {
namespace {

/// Different labels that one landmark remembers: a detector that makes up new ones must not fill the memory.
constexpr std::size_t kMostLabels = 100;

}  // namespace

std::string LandmarkInfo::label() const {
  const auto most =
      std::max_element(label_votes.begin(), label_votes.end(),
                       [](const auto& left, const auto& right) { return left.second < right.second; });
  return most == label_votes.end() ? std::string() : most->first;
}

void LandmarkInfo::add(TimeNs stamp, const Signature& signature) {
  last_seen = stamp;
  ++observations;
  if (source_id == kNoId) source_id = signature.source_id;
  const bool votes = !signature.label.empty() &&
                     (label_votes.size() < kMostLabels || label_votes.count(signature.label) > 0);
  if (votes) ++label_votes[signature.label];
  if (!signature.descriptor.empty()) descriptor = signature.descriptor;
  if (signature.radius > 0.0) {
    ++radius_observations;
    radius += (signature.radius - radius) / radius_observations;
  }
}

void LandmarkInfo::absorb(const LandmarkInfo& other) {
  last_seen = std::max(last_seen, other.last_seen);
  observations += other.observations;
  if (source_id == kNoId) source_id = other.source_id;
  for (const auto& [label, votes] : other.label_votes) label_votes[label] += votes;
  const std::uint32_t radii = radius_observations + other.radius_observations;
  if (radii > 0) {
    radius = (radius * radius_observations + other.radius * other.radius_observations) / radii;
  }
  radius_observations = radii;
  confirmed = confirmed || other.confirmed;
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kMatched:
      return "matched";
    case Verdict::kCreated:
      return "created";
    case Verdict::kOutOfRange:
      return "out_of_range";
    case Verdict::kOutsideGate:
      return "outside_gate";
    case Verdict::kAmbiguous:
      return "ambiguous";
    case Verdict::kNoIdentity:
      return "no_identity";
    case Verdict::kDuplicateIdentity:
      return "duplicate";
    case Verdict::kSingular:
      return "singular";
    case Verdict::kInvalid:
      return "invalid";
    case Verdict::kNotInMap:
      return "not_in_map";
    case Verdict::kMapFull:
      return "map_full";
    case Verdict::kLate:
      return "late";
    case Verdict::kClutter:
      return "clutter";
    case Verdict::kTooMany:
      return "too_many";
  }
  return "unknown";
}

}  // namespace kinect_ekf_slam
