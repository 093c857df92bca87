#include "kinect_ekf_slam/core/compatibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace kinect_ekf_slam {
namespace {

using Append = void (*)(std::string*, double);
using Read = bool (*)(const std::string&, double*);

std::vector<double> numbers() {
  std::vector<double> values{
      0.0, -0.0, 1.0, 0.1, -2.5, 1e22, 1e-300, 5e-324, std::numeric_limits<double>::max()};
  std::mt19937_64 random(1);
  std::normal_distribution<double> exponent(0.0, 5.0);
  for (int i = 0; i < 1000; ++i)
    values.push_back(std::pow(10.0, exponent(random)) * (i % 2 == 0 ? 1.0 : -1.0));
  return values;
}

TEST(Compatibility, NumbersReadBackAsTheyWereWithEitherLibrary) {
  for (const double value : numbers()) {
    for (const Append append : {Append(&append_number), Append(&without_charconv::append_number)}) {
      std::string text;
      append(&text, value);
      for (const Read read : {Read(&read_number<double>), Read(&without_charconv::read_number)}) {
        double again = 1.5;
        ASSERT_TRUE(read(text, &again)) << text;
        EXPECT_EQ(again, value) << text;
        EXPECT_EQ(std::signbit(again), std::signbit(value)) << text;
      }
    }
  }
}

TEST(Compatibility, BothLibrariesWriteTheSameDigits) {
  for (const double value : numbers()) {
    std::string with;
    std::string without;
    append_number(&with, value, 9);
    without_charconv::append_number(&without, value, 9);
    EXPECT_EQ(with, without);
  }
}

TEST(Compatibility, BothLibrariesRefuseWhatIsNoNumber) {
  for (const char* text : {"", " 1", "1 ", "+1", "1,5", "0x10", "1e", "one", "-", "1e999"}) {
    double value = 0.0;
    EXPECT_FALSE(read_number(std::string(text), &value)) << text;
    EXPECT_FALSE(without_charconv::read_number(text, &value)) << text;
  }
  int whole = 0;
  EXPECT_FALSE(read_number(std::string("1.5"), &whole));
  EXPECT_TRUE(read_number(std::string("-15"), &whole));
  EXPECT_EQ(whole, -15);
}

}  // namespace
}  // namespace kinect_ekf_slam
