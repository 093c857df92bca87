#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinect_ekf_slam/models/measurement.h"

namespace kinect_ekf_slam {
namespace {

TEST(CorrelationInflation, IsNoneForWhiteNoise) {
  EXPECT_EQ(correlation_inflation(0.1, 0.0), 1.0);
  EXPECT_EQ(correlation_inflation(0.0, 0.0), 1.0);
  EXPECT_NEAR(correlation_inflation(100.0, 1.0), 1.0, 1e-12);
}

TEST(CorrelationInflation, GrowsWhenSightingsComeCloser) {
  double last = 1.0;
  for (const double since : {5.0, 2.0, 1.0, 0.5, 0.1, 0.01}) {
    const double inflation = correlation_inflation(since, 1.0);
    EXPECT_GT(inflation, last) << since;
    last = inflation;
  }
  EXPECT_NEAR(correlation_inflation(0.01, 1.0), 2.0 / 0.01, 0.1);  // 2 tau / dt
}

TEST(CorrelationInflation, IsBounded) {
  EXPECT_EQ(correlation_inflation(0.0, 1.0), 1e4);
  EXPECT_EQ(correlation_inflation(-1.0, 1.0), 1e4);
  EXPECT_EQ(correlation_inflation(1e-12, 1.0), 1e4);
}

/// The mean of a run of correlated errors varies as the filter thinks that it does with inflated white ones.
TEST(CorrelationInflation, MatchesTheMeanOfAnAutoregressiveProcess) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const double since : {0.1, 0.5, 2.0}) {
    const double correlation_time = 1.0;
    const double rho = std::exp(-since / correlation_time);
    const double inflation = correlation_inflation(since, correlation_time);
    const int count = 1000;
    const int runs = 2000;
    double variance = 0.0;
    for (int run = 0; run < runs; ++run) {
      double error = normal(random);
      double sum = error;
      for (int i = 1; i < count; ++i) {
        error = rho * error + std::sqrt(1.0 - rho * rho) * normal(random);
        sum += error;
      }
      variance += std::pow(sum / count, 2) / runs;
    }
    const double believed = 1.0 / (1.0 + (count - 1) / inflation);
    EXPECT_NEAR(variance / believed, 1.0, 0.13) << since;  // 4 sigma of 2000 runs
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
