#include "kinect_ekf_slam/estimators/histogram_filter.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace kinect_ekf_slam {
namespace {

void expect_belief(const HistogramFilter& filter, const std::vector<double>& expected, double tolerance) {
  ASSERT_EQ(filter.belief().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(filter.belief()[i], expected[i], tolerance) << i;
}

/// The report's question 4: five cells in a ring; the robot stays with 0.1, goes on one cell with 0.8, two
/// with 0.1.
TEST(HistogramFilter, PredictsTheReportsRing) {
  HistogramFilter filter({1.0, 3.0, 3.0, 1.0, 1.0});
  filter.predict({0.1, 0.8, 0.1});
  expect_belief(filter, {0.111, 0.133, 0.311, 0.311, 0.133}, 0.0005);
  expect_belief(filter, {1.0 / 9.0, 2.0 / 15.0, 14.0 / 45.0, 14.0 / 45.0, 2.0 / 15.0}, 1e-12);
}

/// The report's question 3: nine taxis of ten are green, and who says blue is right three times of four.
TEST(HistogramFilter, KnowsTheColourOfTheTaxi) {
  HistogramFilter green_or_blue({0.9, 0.1});
  EXPECT_NEAR(green_or_blue.correct({0.25, 0.75}), 0.9 * 0.25 + 0.1 * 0.75, 1e-12);
  expect_belief(green_or_blue, {0.75, 0.25}, 1e-12);
}

TEST(HistogramFilter, FindsARobotThatSeesADoor) {
  HistogramFilter filter(std::vector<double>(5, 1.0));
  const std::vector<double> door_at_0_and_2 = {0.9, 0.1, 0.9, 0.1, 0.1};
  const std::vector<double> wall = {0.1, 0.9, 0.1, 0.9, 0.9};
  for (const auto& seen : {door_at_0_and_2, wall, door_at_0_and_2, wall}) {  // only from cell 0 on
    filter.correct(seen);
    filter.predict({0.05, 0.9, 0.05});
  }
  EXPECT_GT(filter.belief()[4], 0.5);
}

TEST(HistogramFilter, GoesRoundTheRingMoreThanOnce) {
  HistogramFilter filter({1.0, 0.0});
  filter.predict({0.0, 0.0, 0.0, 1.0});
  expect_belief(filter, {0.0, 1.0}, 0.0);
}

TEST(HistogramFilter, RefusesWhatIsNoProbability) {
  EXPECT_THROW(HistogramFilter({0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(HistogramFilter({1.0, -0.1}), std::invalid_argument);
  EXPECT_THROW(HistogramFilter({1.0, std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
  HistogramFilter filter({1.0, 0.0});
  EXPECT_THROW(filter.predict({0.5, 0.4}), std::invalid_argument);
  EXPECT_THROW(filter.correct({1.0}), std::invalid_argument);
  EXPECT_THROW(filter.correct({0.0, 1.0}), std::invalid_argument);
  expect_belief(filter, {1.0, 0.0}, 0.0);
}

}  // namespace
}  // namespace kinect_ekf_slam
