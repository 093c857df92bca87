#include "kinect_ekf_slam/estimators/contradictions.h"

#include <gtest/gtest.h>

namespace kinect_ekf_slam {
namespace {

constexpr int kLandmark = 7;
constexpr Assignment kRefused{Verdict::kOutsideGate, kLandmark, 100.0};
constexpr Assignment kSeen{Verdict::kMatched, kLandmark, 1.0};

Contradictions after(int sightings) {
  EstimatorOptions options;
  options.replace_after = sightings;
  return Contradictions(options);
}

/// Messages, each a refused sighting, until one places the landmark anew; 0: none of 20 does.
int messages_to_replace(Contradictions* contradictions, int observations) {
  for (int message = 1; message <= 20; ++message) {
    if (!contradictions->misplaced({kRefused}, [&](int) { return observations; }).empty()) return message;
  }
  return 0;
}

TEST(Contradictions, ALandmarkNeedsAsManyAsSupportItAndAtLeastTheOption) {
  for (const auto& [observations, expected] : {std::pair(1, 3), std::pair(3, 3), std::pair(8, 8)}) {
    Contradictions contradictions = after(3);
    EXPECT_EQ(messages_to_replace(&contradictions, observations), expected);
    EXPECT_EQ(messages_to_replace(&contradictions, observations), expected) << "counts on after it decided";
  }
}

TEST(Contradictions, ZeroNeverReplaces) {
  Contradictions contradictions = after(0);
  EXPECT_EQ(messages_to_replace(&contradictions, 1), 0);
}

TEST(Contradictions, AMatchWashesTheLandmarkClean) {
  Contradictions contradictions = after(3);
  const auto once = [](int) { return 1; };
  contradictions.misplaced({kRefused}, once);
  contradictions.misplaced({kRefused}, once);
  contradictions.misplaced({kSeen}, once);
  EXPECT_EQ(messages_to_replace(&contradictions, 1), 3);
}

TEST(Contradictions, AMessageCountsOnceAndNotAgainstALandmarkThatItMatched) {
  const auto once = [](int) { return 1; };
  Contradictions doubled = after(2);
  EXPECT_TRUE(doubled.misplaced({kRefused, kRefused}, once).empty());
  EXPECT_EQ(doubled.misplaced({kRefused, kRefused}, once), std::vector<std::size_t>{0});
  Contradictions matched = after(1);
  EXPECT_TRUE(matched.misplaced({kRefused, kSeen}, once).empty());
}

TEST(Contradictions, LandmarksAreCountedApart) {
  Contradictions contradictions = after(2);
  const auto once = [](int) { return 1; };
  const Assignment other{Verdict::kOutsideGate, 8, 100.0};
  const Assignment nobody{Verdict::kOutsideGate, -1, 100.0};
  EXPECT_TRUE(contradictions.misplaced({nobody, kRefused}, once).empty());
  EXPECT_TRUE(contradictions.misplaced({nobody, other}, once).empty());
  EXPECT_EQ(contradictions.misplaced({nobody, other, kRefused}, once), (std::vector<std::size_t>{1, 2}));
  contradictions.misplaced({kRefused}, once);
  contradictions.forget(kLandmark);
  EXPECT_TRUE(contradictions.misplaced({kRefused}, once).empty());
}

}  // namespace
}  // namespace kinect_ekf_slam
