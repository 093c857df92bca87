#include "kinect_ekf_slam/core/position.h"

namespace kinect_ekf_slam {

const char* to_string(PositionVerdict verdict) {
  switch (verdict) {
    case PositionVerdict::kUsed:
      return "used";
    case PositionVerdict::kAligning:
      return "aligning";
    case PositionVerdict::kOutsideGate:
      return "outside_gate";
    case PositionVerdict::kSingular:
      return "singular";
    case PositionVerdict::kInvalid:
      return "invalid";
    case PositionVerdict::kLate:
      return "late";
    case PositionVerdict::kWithheld:
      return "withheld";
    case PositionVerdict::kUnknownBeacon:
      return "unknown_beacon";
    case PositionVerdict::kUnsupported:
      return "unsupported";
  }
  return "";
}

}  // namespace kinect_ekf_slam
