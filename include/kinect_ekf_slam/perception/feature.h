#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "kinect_ekf_slam/perception/depth_noise.h"
#include "kinect_ekf_slam/perception/findings.h"
#include "kinect_ekf_slam/perception/keypoint_matcher.h"
#include "kinect_ekf_slam/perception/keypoints.h"
#include "kinect_ekf_slam/perception/picture.h"
#include "kinect_ekf_slam/perception/two_views.h"

namespace kinect_ekf_slam {

struct FeatureOptions {
  KeypointOptions keypoints;
  MatchOptions matching;
  TwoViewOptions two_views;
  double min_depth = 0.4;  ///< m; readings outside are not used
  double max_depth = 5.0;  ///< m
  int min_sightings = 4;   ///< pictures that must have shown a feature before it is reported
  int most = 25;  ///< of a picture that are reported, half a cell apart; the oldest tracks come first
  int remembered_keyframes = 50;  ///< pictures in which features that were lost are looked for
  DepthNoise noise;
};

/// Follows natural features from picture to picture. A finding's source_id is the number of its track: an
/// identity that was seen to persist. Pictures come in the order of time.
///
/// Keypoints are matched with those of the picture before and of the keyframe. Now and then a picture becomes
/// the keyframe: the camera's motion since then, from features with depth, tells which features do not move
/// with the rest, and where those are that have no depth. A new keyframe is compared with earlier ones, and
/// features that are found again get their old numbers back.
class FeatureDetector {
 public:
  /// Throws std::invalid_argument for a type of keypoints that this OpenCV does not have.
  explicit FeatureDetector(const FeatureOptions& options);

  /// Throws PictureError when the picture has no colour or cannot be used. Depth may be missing in part.
  Findings detect(const RgbdPicture& picture);

  /// Tracks go on; the keypoints stay what they are.
  void set_options(const FeatureOptions& options) { options_ = options; }

 private:
  /// One keypoint of a picture.
  struct Feature {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    int track = kNoId;
    int sightings = 1;                 ///< of the track
    std::optional<PlacedPoint> place;  ///< in the picture's optical axes; without the errors of the camera
    bool has_depth = false;            ///< its place was read, not triangulated
  };
  struct View {
    PinholeCamera camera;
    Keypoints keypoints;
    std::vector<Feature> features;  ///< one a keypoint

    int index_of(int track) const;  ///< -1: not in this view
    int depths() const;             ///< how many features have one
  };

  View look(const RgbdPicture& picture) const;
  std::optional<PlacedPoint> read_depth(const cv::Mat& depth_in_metres, const PinholeCamera& camera,
                                        const Eigen::Vector2d& pixel) const;
  void follow(View* view);
  void compare_with_keyframe(View* view, Findings* findings);
  std::vector<KeypointPair> common_with_keyframe(const View& view) const;
  /// Leaves of the pairs those that have a depth in the first view; the motion is theirs.
  std::optional<CameraMotion> motion_between(const View& first, const View& second,
                                             std::vector<KeypointPair>* pairs) const;
  void start_keyframe(View* view);
  void find_again(const View& earlier, View* view) const;
  void report(const View& view, Findings* findings) const;

  FeatureOptions options_;
  KeypointDetector detector_;
  View previous_;
  View keyframe_;
  std::deque<View> remembered_;
  int next_track_ = 0;
};

}  // namespace kinect_ekf_slam
