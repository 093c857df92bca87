#include "kinect_ekf_slam/estimators/shared_array.h"

#include <gtest/gtest.h>

#include <map>

#include "kinect_ekf_slam/core/random_stream.h"

namespace kinect_ekf_slam {
namespace {

/// Counts how often it was copied.
struct Counted {
  Counted() = default;
  explicit Counted(int given) : value(given) {}
  Counted(const Counted& other) : value(other.value) { ++copies; }
  Counted(Counted&&) = default;
  Counted& operator=(const Counted&) = default;
  Counted& operator=(Counted&&) = default;
  int value = 0;
  static int copies;
};
int Counted::copies = 0;

TEST(SharedArray, HoldsWhatAMapHolds) {
  RandomStream random(1, 0);
  SharedArray<int> array;
  std::map<int, int> expected;
  for (int i = 0; i < 5000; ++i) {
    const int index = static_cast<int>(random.index(300));
    if (random.chance(0.3)) {
      array.erase(index);
      expected.erase(index);
    } else {
      array.set(index, i);
      expected[index] = i;
    }
  }
  for (int index = 0; index < 400; ++index) {
    const int* entry = array.find(index);
    const auto known = expected.find(index);
    ASSERT_EQ(entry != nullptr, known != expected.end()) << index;
    if (entry != nullptr) {
      EXPECT_EQ(*entry, known->second);
    }
  }
}

TEST(SharedArray, ACopyChangesOnItsOwn) {
  SharedArray<int> original;
  for (int i = 0; i < 100; ++i) original.set(i, i);
  SharedArray<int> copy = original;
  copy.set(70, -1);
  copy.erase(20);
  original.set(30, -2);
  EXPECT_EQ(*original.find(70), 70);
  EXPECT_EQ(*original.find(20), 20);
  EXPECT_EQ(*copy.find(30), 30);
  EXPECT_EQ(*copy.find(70), -1);
  EXPECT_EQ(copy.find(20), nullptr);
}

/// What FastSLAM's O(M log n) rests on.
TEST(SharedArray, ACopyAndAChangeTouchTheWayToTheEntryAlone) {
  SharedArray<Counted> original;
  const int n = 1 << 14;
  for (int i = 0; i < n; ++i) original.set(i, Counted(i));
  Counted::copies = 0;
  SharedArray<Counted> copy = original;
  EXPECT_EQ(Counted::copies, 0);
  copy.set(n - 1, Counted(-1));
  EXPECT_LE(Counted::copies, 15) << "log2 n nodes";
  Counted::copies = 0;
  copy.set(n - 1, Counted(-2));
  EXPECT_EQ(Counted::copies, 0) << "the way is its own by now";
}

}  // namespace
}  // namespace kinect_ekf_slam
