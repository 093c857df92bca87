#include "kinect_ekf_slam/perception/feature.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kinect_ekf_slam {
namespace {

constexpr double kRenewBelow = 0.3;  // share of a keyframe's features that must still be followed

Region region_of(const cv::KeyPoint& point) {
  constexpr float kSmallest = 6.0F;
  const float size = std::max(kSmallest, point.size);
  return {cvRound(point.pt.x - 0.5F * size), cvRound(point.pt.y - 0.5F * size), cvRound(size), cvRound(size)};
}

/// Bits as zeros and ones, vectors as they are, scaled so that those of unrelated spots are about 1 apart:
/// half of their bits differ.
std::vector<float> to_message_descriptor(const cv::Mat& row) {
  constexpr int kBits = 8;
  if (row.depth() != CV_8U) {
    const cv::Mat unit = row / std::max(cv::norm(row), 1e-6);
    return {unit.begin<float>(), unit.end<float>()};
  }
  std::vector<float> bits;
  const float one = std::sqrt(2.0F / static_cast<float>(kBits * row.cols));
  for (int column = 0; column < row.cols; ++column) {
    for (int bit = 0; bit < kBits; ++bit) {
      bits.push_back((row.at<std::uint8_t>(0, column) >> bit) % 2 == 0 ? 0.0F : one);
    }
  }
  return bits;
}

}  // namespace

FeatureDetector::FeatureDetector(const FeatureOptions& options)
    : options_(options), detector_(options.keypoints) {}

Findings FeatureDetector::detect(const RgbdPicture& picture) {
  check(picture);
  if (picture.colour.empty()) throw PictureError("no colour in the picture");
  View view = look(picture);
  Findings findings;
  follow(&view);
  compare_with_keyframe(&view, &findings);
  report(view, &findings);
  previous_ = std::move(view);
  return findings;
}

int FeatureDetector::View::index_of(int track) const {
  const auto found = std::find_if(features.begin(), features.end(),
                                  [&](const Feature& feature) { return feature.track == track; });
  return found == features.end() ? -1 : static_cast<int>(found - features.begin());
}

int FeatureDetector::View::depths() const {
  return static_cast<int>(std::count_if(features.begin(), features.end(),
                                        [](const Feature& feature) { return feature.has_depth; }));
}

FeatureDetector::View FeatureDetector::look(const RgbdPicture& picture) const {
  View view;
  view.camera = picture.camera;
  view.keypoints = detector_.detect(picture.colour);
  const cv::Mat depth = picture.depth.empty() ? cv::Mat() : depth_in_metres(picture.depth);
  for (const cv::KeyPoint& point : view.keypoints.points) {
    Feature feature;
    feature.pixel = Eigen::Vector2d(point.pt.x, point.pt.y);
    if (!depth.empty()) feature.place = read_depth(depth, picture.camera, feature.pixel);
    feature.has_depth = feature.place.has_value();
    view.features.push_back(feature);
  }
  return view;
}

/// The median of the readings around the pixel; nothing at an edge, where it is not known whose depth it is.
std::optional<PlacedPoint> FeatureDetector::read_depth(const cv::Mat& depth_in_metres,
                                                       const PinholeCamera& camera,
                                                       const Eigen::Vector2d& pixel) const {
  constexpr int kReach = 2;            // pixels
  constexpr std::size_t kFewest = 13;  // readings, of 25
  constexpr double kSteepest = 0.03;   // m/m: of a surface, over the window
  std::vector<double> readings;
  const cv::Point middle(cvRound(pixel.x()), cvRound(pixel.y()));
  for (int row = middle.y - kReach; row <= middle.y + kReach; ++row) {
    for (int column = middle.x - kReach; column <= middle.x + kReach; ++column) {
      const bool is_inside =
          row >= 0 && column >= 0 && row < depth_in_metres.rows && column < depth_in_metres.cols;
      const double depth = is_inside ? depth_in_metres.at<float>(row, column) : 0.0;
      if (depth >= options_.min_depth && depth <= options_.max_depth) readings.push_back(depth);
    }
  }
  if (readings.size() < kFewest) return std::nullopt;
  const auto median = readings.begin() + static_cast<std::ptrdiff_t>(readings.size() / 2);
  std::nth_element(readings.begin(), median, readings.end());
  const double depth = *median;
  const auto [nearest, farthest] = std::minmax_element(readings.begin(), readings.end());
  if (*farthest - *nearest > 2.0 * options_.noise.step(depth) + kSteepest * depth) return std::nullopt;

  // First order: along the ray by the reading, aside by the keypoint. The readings' noise is that of one:
  // neighbours share the windows that a Kinect compares.
  const Eigen::Vector3d ray = camera.ray(pixel.x(), pixel.y());
  const Eigen::Vector2d aside =
      options_.two_views.pixel_sigma * depth * Eigen::Vector2d(1.0 / camera.fx, 1.0 / camera.fy);
  PlacedPoint place{depth * ray, options_.noise.mean_variance(depth, 1) * ray * ray.transpose()};
  place.covariance.diagonal().head<2>() += aside.cwiseAbs2();
  return place;
}

/// Features that the picture before had, or the keyframe, keep their tracks; the others begin new ones.
void FeatureDetector::follow(View* view) {
  for (const View* earlier : {&previous_, &keyframe_}) {
    for (const auto& [before, now] : match(earlier->keypoints, view->keypoints, options_.matching)) {
      const Feature& then = earlier->features[before];
      Feature& feature = view->features[now];
      if (feature.track != kNoId || view->index_of(then.track) >= 0) continue;
      feature.track = then.track;
      feature.sightings = then.sightings + 1;
    }
  }
  for (Feature& feature : view->features) {
    if (feature.track == kNoId) feature.track = next_track_++;
  }
}

std::vector<KeypointPair> FeatureDetector::common_with_keyframe(const View& view) const {
  std::vector<KeypointPair> pairs;
  for (std::size_t i = 0; i < view.features.size(); ++i) {
    const int in_keyframe = keyframe_.index_of(view.features[i].track);
    if (in_keyframe >= 0) pairs.push_back({in_keyframe, static_cast<int>(i)});
  }
  return pairs;
}

std::optional<CameraMotion> FeatureDetector::motion_between(const View& first, const View& second,
                                                            std::vector<KeypointPair>* pairs) const {
  std::vector<KeypointPair> placed;
  std::vector<PlacedPoint> points;
  std::vector<Eigen::Vector2d> pixels;
  for (const KeypointPair& pair : *pairs) {
    if (!first.features[pair.first].has_depth) continue;
    placed.push_back(pair);
    points.push_back(*first.features[pair.first].place);
    pixels.push_back(second.features[pair.second].pixel);
  }
  *pairs = std::move(placed);
  return find_motion(points, pixels, second.camera, options_.two_views);
}

void FeatureDetector::compare_with_keyframe(View* view, Findings* findings) {
  const std::vector<KeypointPair> common = common_with_keyframe(*view);
  std::vector<KeypointPair> placed = common;
  const auto motion = motion_between(keyframe_, *view, &placed);
  if (!motion) return start_keyframe(view);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (motion->agrees[i]) continue;
    Feature& feature = view->features[placed[i].second];
    findings->refused.push_back(
        {"moves against the rest", region_of(view->keypoints.points[placed[i].second])});
    feature.track = next_track_++;
    feature.sightings = 1;
  }
  for (const auto& [then, now] : common) {
    Feature& feature = view->features[now];
    if (feature.place) continue;
    feature.place =
        triangulate(keyframe_.features[then].pixel, feature.pixel, *motion, view->camera, options_.two_views);
  }
  const auto agreeing = std::count(motion->agrees.begin(), motion->agrees.end(), true);
  if (static_cast<double>(agreeing) < kRenewBelow * keyframe_.depths()) start_keyframe(view);
}

void FeatureDetector::start_keyframe(View* view) {
  if (keyframe_.depths() >= options_.matching.fewest) remembered_.push_back(keyframe_);
  if (static_cast<int>(remembered_.size()) > options_.remembered_keyframes) remembered_.pop_front();
  for (const View& earlier : remembered_) find_again(earlier, view);
  keyframe_ = *view;
}

/// The older track of the same feature goes on.
void FeatureDetector::find_again(const View& earlier, View* view) const {
  std::vector<KeypointPair> pairs = match(earlier.keypoints, view->keypoints, options_.matching);
  const auto motion = motion_between(earlier, *view, &pairs);
  if (!motion) return;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Feature& then = earlier.features[pairs[i].first];
    Feature& now = view->features[pairs[i].second];
    if (!motion->agrees[i] || then.track >= now.track || view->index_of(then.track) >= 0) continue;
    now.track = then.track;
    now.sightings = std::max(now.sightings, then.sightings + 1);
  }
}

void FeatureDetector::report(const View& view, Findings* findings) const {
  std::vector<std::size_t> order(view.features.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t left, std::size_t right) {
    return view.features[left].track < view.features[right].track;
  });
  // What is close together shows the same corner, and errs alike.
  const double nearest = 0.5 * options_.keypoints.cell_size;
  std::vector<Eigen::Vector2d> reported;
  const auto is_apart = [&](const Eigen::Vector2d& pixel) {
    return std::all_of(reported.begin(), reported.end(),
                       [&](const Eigen::Vector2d& other) { return (pixel - other).norm() >= nearest; });
  };
  for (const std::size_t i : order) {
    const Feature& feature = view.features[i];
    const cv::KeyPoint& point = view.keypoints.points[i];
    if (feature.sightings < options_.min_sightings) continue;
    if (!feature.place) {
      findings->refused.push_back({"no depth", region_of(point)});
      continue;
    }
    if (static_cast<int>(findings->found.size()) >= options_.most) break;
    if (!is_apart(feature.pixel)) continue;
    reported.push_back(feature.pixel);
    Finding finding;
    finding.position = feature.place->position;
    const Eigen::Matrix3d covariance =
        feature.place->covariance + options_.noise.camera_covariance(finding.position);
    finding.covariance = 0.5 * (covariance + covariance.transpose());
    finding.signature.source_id = feature.track;
    finding.signature.descriptor = to_message_descriptor(view.keypoints.descriptors.row(static_cast<int>(i)));
    finding.score = 1.0 - 1.0 / feature.sightings;
    finding.region = region_of(point);
    findings->found.push_back(std::move(finding));
  }
}

}  // namespace kinect_ekf_slam
