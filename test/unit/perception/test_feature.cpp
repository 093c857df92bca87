#include "kinect_ekf_slam/perception/feature.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <map>
#include <opencv2/core.hpp>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/unit/perception/textured.h"

namespace kinect_ekf_slam {
namespace {

/// The camera of textured_room() `aside` to the left, turned to the left by `turn` (rad).
Eigen::Isometry3d camera(double aside, double turn = 0.0) {
  Eigen::Isometry3d world_from_optical = testing::camera_at(1.0, 0.0);
  world_from_optical.translation().y() = aside;
  world_from_optical.linear() =
      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * world_from_optical.linear();
  return world_from_optical;
}

/// Looks at rendered pictures one after the other and remembers where each track was first.
class Walk {
 public:
  explicit Walk(const FeatureOptions& options = {}, Scene scene = testing::textured_room())
      : detector_(options), scene_(std::move(scene)) {}

  Findings look(const Eigen::Isometry3d& world_from_optical) {
    RgbdPicture picture = testing::photograph(scene_, world_from_optical, ++pictures_);
    if (blind_from_ < picture.depth.cols) picture.depth.colRange(blind_from_, picture.depth.cols).setTo(0.0);
    return detector_.detect(picture);
  }
  /// Without readings from this column on.
  void blind_from(int column) { blind_from_ = column; }
  Scene& scene() { return scene_; }

 private:
  FeatureDetector detector_;
  Scene scene_;
  int blind_from_ = 10000;
  std::uint64_t pictures_ = 0;
};

TEST(Feature, ReportsOnlyWhatSeveralPicturesShowed) {
  FeatureOptions options;
  options.min_sightings = 4;
  Walk walk(options);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(walk.look(camera(0.03 * i)).found.empty()) << i;
  EXPECT_GE(walk.look(camera(0.09)).found.size(), 20U);
}

TEST(Feature, ReportsAreFewAndApart) {
  FeatureOptions options;
  options.most = 12;
  Walk walk(options);
  Findings findings;
  for (int i = 0; i < 6; ++i) findings = walk.look(camera(0.03 * i));
  ASSERT_EQ(findings.found.size(), 12U);
  for (const Finding& one : findings.found) {
    for (const Finding& other : findings.found) {
      if (&one == &other) continue;
      const Eigen::Vector2d difference =
          PinholeCamera().project(one.position) - PinholeCamera().project(other.position);
      EXPECT_GE(difference.norm(), 0.5 * options.keypoints.cell_size - 1e-6);
    }
  }
}

TEST(Feature, ATrackIsOnePlaceAndItsCovarianceHonest) {
  Walk walk;
  std::map<int, Eigen::Vector3d> place_of_track;
  double nees = 0.0;
  int again = 0;
  int elsewhere = 0;
  for (int i = 0; i < 25; ++i) {
    const Eigen::Isometry3d world_from_optical = camera(0.03 * i, 0.01 * i);
    for (const Finding& finding : walk.look(world_from_optical).found) {
      EXPECT_TRUE(testing::IsCovariance(finding.covariance));
      EXPECT_EQ(finding.signature.descriptor.size(), 256U);
      const Eigen::Vector3d place = world_from_optical * finding.position;
      const auto [known, is_new] = place_of_track.emplace(finding.signature.source_id, place);
      if (is_new) continue;
      const Eigen::Vector3d difference = world_from_optical.linear().transpose() * (place - known->second);
      const Eigen::Matrix3d of_both = 2.0 * finding.covariance;
      nees += difference.dot(of_both.ldlt().solve(difference));
      ++again;
      elsewhere += difference.norm() > 0.15 ? 1 : 0;
    }
  }
  EXPECT_GT(again, 300);
  EXPECT_LT(elsewhere, 0.01 * again);
  EXPECT_LT(nees / again, 3.5);
  EXPECT_GT(again, 3 * static_cast<int>(place_of_track.size())) << "tracks are long";
}

/// Mean length of the difference of the descriptors, of two sightings of one track or of different ones.
double descriptor_difference(const Findings& before, const Findings& now, bool of_one_track) {
  double sum = 0.0;
  int pairs = 0;
  for (const Finding& one : before.found) {
    for (const Finding& other : now.found) {
      if ((one.signature.source_id == other.signature.source_id) != of_one_track) continue;
      sum += cv::norm(one.signature.descriptor, other.signature.descriptor);
      ++pairs;
    }
  }
  EXPECT_GT(pairs, 10);
  return sum / pairs;
}

/// So that one `association/descriptor_sigma` serves all types.
TEST(Feature, DescriptorsOfUnrelatedSpotsAreAboutOneApart) {
  for (const KeypointType type :
       {KeypointType::kHarris, KeypointType::kSift, KeypointType::kOrb, KeypointType::kAkaze}) {
    SCOPED_TRACE(static_cast<int>(type));
    FeatureOptions options;
    options.keypoints.type = type;
    options.most = 100;
    Walk walk(options);
    for (int i = 0; i < 4; ++i) walk.look(camera(0.03 * i));
    const Findings before = walk.look(camera(0.12));
    const Findings now = walk.look(camera(0.15));
    EXPECT_NEAR(descriptor_difference(before, now, false), 1.0, 0.1);
    EXPECT_LT(descriptor_difference(before, now, true), 0.5);
  }
}

TEST(Feature, WhereDepthIsMissingTwoViewsTellIt) {
  FeatureOptions options;
  options.most = 100;
  Walk walk(options);
  walk.blind_from(320);
  int right_half = 0;
  int consistent = 0;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Isometry3d world_from_optical = camera(0.04 * i);
    for (const Finding& finding : walk.look(world_from_optical).found) {
      if (finding.region.left < 330) continue;
      ++right_half;
      // On the wall, the floor or the panel: whichever is nearest must be near enough.
      const Eigen::Vector3d place = world_from_optical * finding.position;
      const Eigen::Vector3d in_panel = place - Eigen::Vector3d(1.8, -0.4, 1.0);
      const double to_panel = in_panel.cwiseAbs().maxCoeff() < 0.45 ? std::abs(in_panel.x()) - 0.1 : 10.0;
      const double off = std::min({std::abs(place.x() - 3.0), std::abs(place.z()), to_panel});
      const double sigma = std::sqrt(finding.covariance.diagonal().maxCoeff());
      consistent += off < 3.0 * sigma ? 1 : 0;
    }
  }
  EXPECT_GT(right_half, 30);
  EXPECT_GT(consistent, 0.95 * right_half);
}

TEST(Feature, WithoutAnyDepthNothingIsReported) {
  Walk walk;
  walk.blind_from(0);
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(walk.look(camera(0.04 * i)).found.empty());
}

TEST(Feature, WhatWasLostIsFoundAgainUnderItsNumber) {
  Walk walk;
  std::map<int, Eigen::Vector3d> before;
  for (int i = 0; i < 8; ++i) {
    for (const Finding& finding : walk.look(camera(0.02 * i)).found) {
      before[finding.signature.source_id] = camera(0.02 * i) * finding.position;
    }
  }
  // All round, and back from the other side.
  for (int i = 1; i <= 40; ++i) walk.look(camera(0.14, 2.0 * kPi * i / 40.0));
  int same = 0;
  std::size_t seen = 0;
  for (int i = 0; i < 6; ++i) {
    for (const Finding& finding : walk.look(camera(0.14 - 0.01 * i)).found) {
      ++seen;
      const auto known = before.find(finding.signature.source_id);
      if (known == before.end()) continue;
      ++same;
      EXPECT_LT((camera(0.14 - 0.01 * i) * finding.position - known->second).norm(), 0.12);
    }
  }
  EXPECT_GT(seen, 60U);
  EXPECT_GT(same, 20);
}

TEST(Feature, WhatMovesByItselfIsRefused) {
  Walk walk;
  Panel& panel = walk.scene().panels.back();
  int refused_on_panel = 0;
  int refused_elsewhere = 0;
  const Eigen::Vector3d start = panel.corner_in_world;
  for (int i = 0; i < 10; ++i) {
    panel.corner_in_world = start + Eigen::Vector3d(0.0, 0.03 * i, 0.0);
    const Eigen::Vector3d middle = panel.corner_in_world + 0.5 * (panel.along + panel.down);
    const Eigen::Vector2d pixel = PinholeCamera().project(camera(0.0).inverse() * middle);
    for (const Refusal& refusal : walk.look(camera(0.0)).refused) {
      if (refusal.reason != "moves against the rest") continue;
      const bool is_on_panel = std::abs(refusal.region.left - pixel.x()) < 130.0;
      (is_on_panel ? refused_on_panel : refused_elsewhere) += 1;
    }
  }
  EXPECT_GT(refused_on_panel, 10);
  EXPECT_LT(refused_elsewhere, refused_on_panel / 4);
}

TEST(Feature, NeedsColourAndSurvivesAnEmptyPicture) {
  FeatureDetector detector({});
  RgbdPicture picture;
  picture.depth = cv::Mat(480, 640, CV_16UC1, cv::Scalar(1000));
  EXPECT_THROW(detector.detect(picture), PictureError);
  picture.colour = cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 0));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(detector.detect(picture).found.empty());
}

TEST(Feature, AnotherOptionDoesNotEndTracks) {
  FeatureDetector detector({});
  const auto look = [&](std::uint64_t seed) {
    return detector.detect(testing::photograph(testing::textured_room(), camera(0.0), seed));
  };
  std::vector<int> before;
  for (std::uint64_t i = 0; i < 5; ++i) {
    before.clear();
    for (const Finding& finding : look(i).found) before.push_back(finding.signature.source_id);
  }
  ASSERT_FALSE(before.empty());
  FeatureOptions options;
  options.most = 5;
  detector.set_options(options);
  const Findings after = look(9);
  ASSERT_EQ(after.found.size(), 5U);
  for (const Finding& finding : after.found) {
    EXPECT_EQ(std::count(before.begin(), before.end(), finding.signature.source_id), 1);
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
