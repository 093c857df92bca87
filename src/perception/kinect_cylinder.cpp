#include "kinect_ekf_slam/perception/kinect_cylinder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/perception/cylinder_wall.h"

namespace kinect_ekf_slam {
namespace {

constexpr int kPlaneSamples = 2000;
constexpr double kWidest = 6.0;              // times the largest radius; a cylinder may touch something else
constexpr std::size_t kSmallestOutline = 8;  // points
constexpr double kLargestResidual = 3.0;     // of an outline's point on the circle, in standard deviations
constexpr double kLowestShare = 0.6;         // of an outline's points that must lie on the circle
constexpr double kCornerPenalty = 4.0;  // for its two parameters more than a circle's (Akaike's criterion)
constexpr double kFullArc = 1.6;        // rad; so much or more is seen of a cylinder that nothing hides
constexpr double kUprightShare = 0.65;  // of the height that the wall must have; a bowl has less
constexpr double kCutScore = 0.5;       // for what the picture's border cuts off
constexpr double kHeightSigma = 0.001;  // m
constexpr double kBackground = 1.1;     // times an object's depth

std::vector<Eigen::Vector3d> sample_readings(const DepthCloud& cloud) {
  std::vector<Eigen::Vector3d> readings;
  const std::size_t step = std::max<std::size_t>(1, cloud.points_in_optical.size() / kPlaneSamples);
  for (std::size_t i = 0; i < cloud.points_in_optical.size(); i += step) {
    if (cloud.has_reading(static_cast<int>(i))) readings.push_back(cloud.points_in_optical[i]);
  }
  return readings;
}

/// The circle that most of an outline lies on, and that part of the outline.
struct RoundOutline {
  Circle circle;
  Outline points;
};

std::optional<RoundOutline> round_part(const Outline& outline, const RadiusBounds& bounds) {
  constexpr int kRounds = 8;
  Outline kept = outline;
  for (int i = 0; i < kRounds; ++i) {
    const auto circle = fit_circle(kept, bounds);
    if (!circle) return std::nullopt;
    // The first circles may be drawn aside by what does not belong to it: only the worst go then.
    const double spread = std::sqrt(circle->chi_square / static_cast<double>(kept.size()));
    Outline next;
    for (const OutlinePoint& point : outline) {
      if (std::abs(circle->residual(point)) <= std::max(kLargestResidual, 2.0 * spread))
        next.push_back(point);
    }
    if (next.size() == kept.size() || i + 1 == kRounds) return RoundOutline{*circle, kept};
    kept = std::move(next);
  }
  return std::nullopt;
}

std::string text(const char* format, double a, double b = 0.0) {
  char buffer[64];
  std::snprintf(buffer, sizeof(buffer), format, a, b);
  return buffer;
}

/// Looks at the clusters of one picture.
class CandidateJudge {
 public:
  CandidateJudge(const KinectCylinderOptions& options, const Palette& palette, const RgbdPicture& picture,
                 const DepthCloud& cloud, const SupportPlane& plane)
      : options_(options), palette_(palette), picture_(picture), cloud_(cloud), plan_(plane) {}

  void judge(const Cluster& cluster, Findings* findings) const {
    Finding finding;
    std::string reason = describe(cluster, &finding);
    if (reason.empty()) {
      findings->found.push_back(std::move(finding));
    } else {
      findings->refused.push_back({std::move(reason), cluster.region});
    }
  }

 private:
  /// Which sides of the picture cut the object off.
  struct Border {
    bool side = false;
    bool top = false;
    bool bottom = false;
  };

  Border border_of(const Region& region) const {
    const int margin = 2 * cloud_.stride;
    return {region.left < margin || region.left + region.width > picture_.depth.cols - margin,
            region.top<margin, region.top + region.height> picture_.depth.rows - margin};
  }

  std::vector<PlanPoint> points_of(const Cluster& cluster) const {
    std::vector<PlanPoint> points;
    points.reserve(cluster.indices.size());
    for (const int index : cluster.indices)
      points.push_back(plan_.view(cloud_.points_in_optical[index], index));
    return points;
  }

  /// Fills the finding; returns why it is none, empty: it is one.
  std::string describe(const Cluster& cluster, Finding* finding) const {
    const std::vector<PlanPoint> points = points_of(cluster);
    Eigen::Vector2d low = points.front().place;
    Eigen::Vector2d high = low;
    double nearest = std::numeric_limits<double>::infinity();
    double depth = 0.0;
    double highest = 0.0;
    for (const PlanPoint& point : points) {
      low = low.cwiseMin(point.place);
      high = high.cwiseMax(point.place);
      nearest = std::min(nearest, point.place.norm());
      highest = std::max(highest, point.height);
      depth += point.depth / static_cast<double>(points.size());
    }
    if ((high - low).maxCoeff() > kWidest * options_.radius.max) return "too wide";
    if (highest > options_.max_height) return text("%.2f m high", highest);
    const double footprint = cloud_.stride / picture_.camera.fx;
    const Border cut = border_of(cluster.region);
    UprightOutlineOptions outline_options = options_.outline;
    if (cut.bottom) outline_options.largest_base = options_.max_height;  // it begins where the picture does
    const Outline outline =
        upright_outline(points, footprint * depth / nearest, options_.noise, outline_options);
    if (outline.size() < kSmallestOutline) return "no upright wall";
    const auto round = round_part(outline, options_.radius);
    if (!round) return "not round";
    if (std::string reason = reason_against(*round, outline.size()); !reason.empty()) return reason;
    const CylinderWall wall = follow_wall(points, round->circle, options_.noise, footprint);
    if (std::string reason = reason_against(wall, cut); !reason.empty()) return reason;
    *finding = measure(*round, wall, cluster.region, cut);
    return {};
  }

  std::string reason_against(const RoundOutline& round, std::size_t outline_size) const {
    const auto& [circle, kept] = round;
    const auto count = static_cast<double>(kept.size());
    if (count < kLowestShare * static_cast<double>(outline_size)) return "not round";
    const double misfit = circle.chi_square / count;
    if (misfit > options_.max_misfit) return text("not round: misfit %.1f", misfit);
    if (!options_.radius.contain(circle.radius)) return text("radius %.3f m", circle.radius);
    const Arc arc = arc_of(circle, kept);
    if (arc.is_hollow()) return "hollow";
    if (arc.whole() < options_.min_arc) return text("only %.0f deg of it seen", degrees(arc.whole()));
    if (corner_chi_square(kept) + kCornerPenalty < circle.chi_square) return "corner or flat face";
    return {};
  }

  std::string reason_against(const CylinderWall& wall, const Border& cut) const {
    if (wall.indices.empty()) return "no upright wall";
    if (cut.top) return "top not seen: it may be a leg";
    if (!cut.bottom && wall.base > options_.outline.largest_base)
      return text("begins %.2f m above the plane", wall.base);
    if (wall.top < options_.min_height) return text("%.2f m high", wall.top);
    if (!cut.bottom && wall.top - wall.base < kUprightShare * wall.top) return "upright in a part only";
    if (std::abs(wall.taper) > options_.max_taper) return text("not upright: taper %.2f", wall.taper);
    if (wall.share_outside > options_.max_share_outside) return "not round: parts stick out";
    return {};
  }

  Finding measure(const RoundOutline& round, const CylinderWall& wall, const Region& region,
                  const Border& cut) const {
    const Circle& circle = round.circle;
    Finding finding;
    finding.position = plan_.to_optical(circle.center, 0.5 * (wall.top - grown(wall)));
    finding.covariance = covariance_of(round, finding.position);
    finding.signature.radius = circle.radius;
    finding.signature.label = label_of(wall);
    const Arc arc = arc_of(circle, round.points);
    finding.score = std::min(1.0, arc.whole() / kFullArc) * 0.5 * (1.0 + arc.symmetry());
    if (cut.side || cut.bottom) finding.score *= kCutScore;
    finding.region = region;
    return finding;
  }

  /// The fit's, and what it cannot know: where the object's edges are exactly, its height, and how far off
  /// the camera is as a whole.
  Eigen::Matrix3d covariance_of(const RoundOutline& round, const Eigen::Vector3d& position) const {
    const Circle& circle = round.circle;
    const double misfit = circle.chi_square / static_cast<double>(round.points.size());
    const double blur = options_.edge_blur * position.z();
    const Eigen::Vector2d direction = circle.center.normalized();
    Eigen::Matrix3d in_plan = Eigen::Matrix3d::Zero();
    in_plan.topLeftCorner<2, 2>() = std::max(1.0, misfit) * circle.covariance.topLeftCorner<2, 2>() +
                                    blur * blur * direction * direction.transpose();
    in_plan(2, 2) = kHeightSigma * kHeightSigma + blur * blur;
    const Eigen::Matrix3d& turn = plan_.optical_from_plan();
    const Eigen::Matrix3d covariance =
        turn * in_plan * turn.transpose() + options_.noise.camera_covariance(position);
    return 0.5 * (covariance + covariance.transpose());
  }

  /// m by which the wall's upper edge seems too high: before a background it grows by half a window, before a
  /// lid it does not.
  double grown(const CylinderWall& wall) const {
    constexpr int kHalfWindow = 4;                                                    // pixels
    const int highest = *std::min_element(wall.indices.begin(), wall.indices.end());  // row after row
    const int above = highest - (2 * kHalfWindow / cloud_.stride + 1) * cloud_.columns;
    const double depth = cloud_.points_in_optical[highest].z();
    const bool has_lid =
        above >= 0 && cloud_.has_reading(above) && cloud_.points_in_optical[above].z() < kBackground * depth;
    return has_lid ? 0.0 : kHalfWindow * depth / picture_.camera.fy;
  }

  std::string label_of(const CylinderWall& wall) const {
    if (picture_.colour.empty()) return {};
    std::vector<cv::Vec3b> pixels;
    pixels.reserve(wall.indices.size());
    for (const int index : wall.indices) {
      pixels.push_back(picture_.colour.at<cv::Vec3b>(cloud_.row_of(index) * cloud_.stride,
                                                     cloud_.column_of(index) * cloud_.stride));
    }
    return colour_label(pixels, palette_);
  }

  const KinectCylinderOptions& options_;
  const Palette& palette_;
  const RgbdPicture& picture_;
  const DepthCloud& cloud_;
  PlanView plan_;
};

}  // namespace

Findings KinectCylinderDetector::detect(const RgbdPicture& picture,
                                        const std::optional<Eigen::Vector3d>& up_in_optical) const {
  check(picture);
  if (picture.depth.empty()) throw PictureError("no depth in the picture");
  const DepthCloud cloud = make_cloud(depth_in_metres(picture.depth), picture.camera, options_.stride,
                                      options_.min_depth, options_.max_depth);
  SupportPlaneOptions plane_options = options_.plane;
  if (up_in_optical) {
    plane_options.up_in_optical = *up_in_optical;
    plane_options.largest_tilt = options_.gravity_tolerance;
  }
  Findings findings;
  const auto plane = find_support_plane(sample_readings(cloud), options_.noise, plane_options);
  if (!plane) {
    findings.refused.push_back({"no supporting plane", {0, 0, picture.depth.cols, picture.depth.rows}});
    return findings;
  }
  const CandidateJudge judge(options_, palette_, picture, cloud, *plane);
  for (const Cluster& cluster :
       find_clusters(cloud, picture.camera, *plane, options_.noise, options_.clusters)) {
    judge.judge(cluster, &findings);
  }
  return findings;
}

}  // namespace kinect_ekf_slam
