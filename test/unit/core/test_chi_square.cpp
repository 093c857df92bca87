#include "kinect_ekf_slam/core/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace kinect_ekf_slam {
namespace {

TEST(ChiSquare, GivesTheReportsGates) {
  EXPECT_NEAR(chi_square_quantile(0.975, 2), 7.378, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.975, 3), 9.348, 5e-4);
}

TEST(ChiSquare, AgreesWithTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841459, 1e-6);
  EXPECT_NEAR(chi_square_quantile(0.99, 6), 16.811894, 1e-6);
  EXPECT_NEAR(chi_square_quantile(0.025, 10), 3.246973, 1e-6);
  EXPECT_NEAR(chi_square_quantile(0.975, 150), 185.800447, 1e-5);
}

TEST(ChiSquare, WithTwoDegreesOfFreedomIsAnExponential) {
  for (const double value : {1e-6, 0.1, 1.0, 5.0, 20.0, 60.0}) {
    EXPECT_NEAR(chi_square_cdf(value, 2), -std::expm1(-0.5 * value), 1e-14) << value;
  }
}

TEST(ChiSquare, QuantileInvertsTheDistribution) {
  for (const double dof : {1.0, 2.0, 3.0, 6.0, 43.0, 500.0}) {
    for (const double probability : {1e-6, 0.025, 0.5, 0.975, 0.99999, 1.0 - 1e-9}) {
      const double value = chi_square_quantile(probability, dof);
      EXPECT_NEAR(chi_square_cdf(value, dof), probability, 1e-12) << dof << " dof, p = " << probability;
    }
  }
}

TEST(ChiSquare, GrowsWithoutAJumpWhereTheMethodChanges) {
  for (const double dof : {1.0, 3.0, 8.0}) {
    const double change = dof + 2.0;  // series below, continued fraction above
    EXPECT_NEAR(chi_square_cdf(change * (1.0 - 1e-12), dof), chi_square_cdf(change * (1.0 + 1e-12), dof),
                1e-11);
  }
}

TEST(ChiSquare, CountsSquaredNormals) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const double quantile = chi_square_quantile(0.9, 3);
  const int draws = 100000;
  int below = 0;
  for (int i = 0; i < draws; ++i) {
    const double x = normal(random);
    const double y = normal(random);
    const double z = normal(random);
    below += x * x + y * y + z * z < quantile ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(below) / draws, 0.9, 0.004);  // 4 sigma
}

TEST(ChiSquare, HasItsBounds) {
  EXPECT_EQ(chi_square_cdf(0.0, 2), 0.0);
  EXPECT_EQ(chi_square_cdf(-1.0, 2), 0.0);
  EXPECT_NEAR(chi_square_cdf(1e4, 2), 1.0, 1e-15);
  EXPECT_NEAR(chi_square_quantile(0.0, 2), 0.0, 1e-300);
}

TEST(ChiSquare, RefusesWhatIsNoProbability) {
  for (const double probability : {1.5, -1e-9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(chi_square_quantile(probability, 2), std::invalid_argument) << probability;
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
