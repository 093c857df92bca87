#include "kinect_ekf_slam/core/chi_square.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace kinect_ekf_slam {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// P(a, x) by its power series, for x < a + 1.
double gamma_series(double a, double x) {
  double term = 1.0 / a;
  double sum = term;
  for (double n = a + 1.0; std::abs(term) > kEpsilon * std::abs(sum); n += 1.0) {
    term *= x / n;
    sum += term;
  }
  return sum * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

/// Q(a, x) = 1 - P(a, x) by its continued fraction (Lentz), for x >= a + 1.
double gamma_fraction(double a, double x) {
  constexpr double kTiny = std::numeric_limits<double>::min() / kEpsilon;
  double b = x + 1.0 - a;
  double c = 1.0 / kTiny;
  double d = 1.0 / b;
  double fraction = d;
  for (int i = 1; i < 10000; ++i) {
    const double numerator = -i * (i - a);
    b += 2.0;
    d = 1.0 / (std::abs(numerator * d + b) < kTiny ? kTiny : numerator * d + b);
    c = std::abs(b + numerator / c) < kTiny ? kTiny : b + numerator / c;
    const double factor = d * c;
    fraction *= factor;
    if (std::abs(factor - 1.0) < kEpsilon) break;
  }
  return fraction * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

}  // namespace

double chi_square_cdf(double value, double dof) {
  if (value <= 0.0) return 0.0;
  const double a = 0.5 * dof;
  const double x = 0.5 * value;
  return x < a + 1.0 ? gamma_series(a, x) : 1.0 - gamma_fraction(a, x);
}

double chi_square_quantile(double probability, double dof) {
  if (!(probability >= 0.0 && probability <= 1.0)) {
    throw std::invalid_argument("chi_square_quantile: probability outside [0, 1]");
  }
  if (probability == 1.0) return std::numeric_limits<double>::infinity();
  double low = 0.0;
  double high = dof + 1.0;
  while (chi_square_cdf(high, dof) < probability) high *= 2.0;
  while (high - low > 4.0 * kEpsilon * high) {  // bisection: monotone, cannot fail, done once at start-up
    const double middle = 0.5 * (low + high);
    (chi_square_cdf(middle, dof) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace kinect_ekf_slam
