#include "kinect_ekf_slam/study/monte_carlo.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <stdexcept>

namespace kinect_ekf_slam {
namespace {

TEST(ForEachRun, RunsEachOnce) {
  std::vector<std::atomic<int>> calls(100);
  double share = 0.0;
  for_each_run(
      calls.size(), [&](std::size_t i) { ++calls[i]; }, [&](double done) { share = done; });
  for (const auto& count : calls) EXPECT_EQ(count, 1);
  EXPECT_LE(share, 1.0);
}

TEST(ForEachRun, AFailureComesOut) {
  EXPECT_THROW(for_each_run(10,
                            [](std::size_t i) {
                              if (i == 3) throw std::runtime_error("three");
                            },
                            {}),
               std::runtime_error);
}

/// `scale` times what a consistent filter's NEES would be: chi-square with three degrees of freedom.
std::vector<std::vector<double>> sampled_nees(double scale) {
  std::mt19937_64 random(7);
  std::chi_squared_distribution<double> nees(3.0);
  std::vector<std::vector<double>> runs(50, std::vector<double>(2000));
  for (auto& run : runs) {
    for (double& value : run) value = scale * nees(random);
  }
  return runs;
}

TEST(Consistency, AnHonestFilterIsInsideTheBoundsNinetyFivePercentOfTheTime) {
  const Consistency honest = consistency(sampled_nees(1.0), 3);
  EXPECT_NEAR(honest.low, 2.36, 0.005);  // the bounds for 50 runs and three degrees of freedom
  EXPECT_NEAR(honest.high, 3.72, 0.005);
  EXPECT_NEAR(honest.mean, 3.0, 0.05);
  EXPECT_NEAR(honest.inside_share, 0.95, 0.015);
}

TEST(Consistency, TooSureAndTooUnsureAreBothSeen) {
  EXPECT_LT(consistency(sampled_nees(1.5), 3).inside_share, 0.2);
  EXPECT_LT(consistency(sampled_nees(0.6), 3).inside_share, 0.2);
}

TEST(Consistency, CountsUpToTheEndOfTheShortestRun) {
  const Consistency result = consistency({{1.0, 2.0, 100.0}, {3.0, 4.0}}, 3);
  ASSERT_EQ(result.mean_nees.size(), 2U);
  EXPECT_DOUBLE_EQ(result.mean_nees[1], 3.0);
}

}  // namespace
}  // namespace kinect_ekf_slam
