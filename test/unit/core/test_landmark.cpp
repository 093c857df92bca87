#include "kinect_ekf_slam/core/landmark.h"

#include <gtest/gtest.h>

#include <set>

namespace kinect_ekf_slam {
namespace {

Signature signature(const std::string& label, int source_id = kNoId, double radius = 0.0) {
  Signature signature;
  signature.label = label;
  signature.source_id = source_id;
  signature.radius = radius;
  return signature;
}

TEST(LandmarkInfo, HasNoLabelBeforeASightingTellsOne) {
  LandmarkInfo info;
  EXPECT_EQ(info.label(), "");
  info.add(1, signature(""));
  EXPECT_EQ(info.label(), "");
  EXPECT_EQ(info.observations, 1U);
}

TEST(LandmarkInfo, TakesTheLabelThatMostSightingsAgreeOn) {
  LandmarkInfo info;
  info.add(1, signature("blue"));
  info.add(2, signature("red"));
  info.add(3, signature("red"));
  for (int i = 0; i < 10; ++i) info.add(4 + i, signature(""));  // silence is no vote
  EXPECT_EQ(info.label(), "red");
  EXPECT_EQ(info.label_votes.size(), 2U);
}

TEST(LandmarkInfo, DoesNotRememberEveryLabelThatADetectorMakesUp) {
  LandmarkInfo info;
  for (int i = 0; i < 1000; ++i) info.add(i, signature("made up " + std::to_string(i)));
  EXPECT_EQ(info.label_votes.size(), 100U);
  info.add(1000, signature("made up 7"));
  EXPECT_EQ(info.label(), "made up 7") << "one that is remembered still gets votes";
}

TEST(LandmarkInfo, KeepsTheFirstIdentityThatWasRead) {
  LandmarkInfo info;
  info.add(1, signature("red"));
  EXPECT_EQ(info.source_id, kNoId);
  info.add(2, signature("red", 7));
  info.add(3, signature("red", 8));
  EXPECT_EQ(info.source_id, 7);
}

TEST(LandmarkInfo, AveragesTheRadiiThatWereTold) {
  LandmarkInfo info;
  info.add(1, signature("", kNoId, 0.05));
  info.add(2, signature("", kNoId, 0.0));
  info.add(3, signature("", kNoId, 0.09));
  EXPECT_NEAR(info.radius, 0.07, 1e-15);
  EXPECT_EQ(info.radius_observations, 2U);
  EXPECT_EQ(info.observations, 3U);
}

TEST(LandmarkInfo, RemembersWhenItWasSeenLast) {
  LandmarkInfo info;
  EXPECT_EQ(info.last_seen, 0);
  info.add(17, signature(""));
  EXPECT_EQ(info.last_seen, 17);
}

TEST(Verdict, EachHasANameOfItsOwn) {
  std::set<std::string> names;
  for (int i = 0; i < kVerdictCount; ++i) {
    const std::string name = to_string(static_cast<Verdict>(i));
    EXPECT_NE(name, "unknown");
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos) << name;
    names.insert(name);
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kVerdictCount));
}

TEST(Verdict, OnlyMatchedAndCreatedEnterTheEstimate) {
  for (int i = 0; i < kVerdictCount; ++i) {
    const auto verdict = static_cast<Verdict>(i);
    EXPECT_EQ(is_accepted(verdict), verdict == Verdict::kMatched || verdict == Verdict::kCreated);
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
