#include "tools/bench/statistics.h"

#include <algorithm>
#include <cmath>

namespace muster::tools {
namespace {

std::vector<double> Known(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  return values;
}

}  // namespace

double Quantile(std::vector<double> values, double rank) {
  values = Known(std::move(values));
  if (values.empty()) return kNotKnown;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(
      std::lround(rank * static_cast<double>(values.size() - 1)))];
}

double PercentUpTo(double most, const std::vector<double>& values) {
  const std::vector<double> known = Known(values);
  const auto small =
      std::count_if(known.begin(), known.end(), [&](double value) { return value <= most; });
  return known.empty() ? kNotKnown
                       : 100 * static_cast<double>(small) / static_cast<double>(known.size());
}

Moments MomentsOf(std::vector<double> values) {
  values = Known(std::move(values));
  Moments moments;
  moments.n = static_cast<int>(values.size());
  const auto n = static_cast<double>(values.size());
  for (const double value : values) moments.mean += value / n;
  if (values.size() < 2) return moments;
  double squares = 0;
  for (const double value : values) squares += (value - moments.mean) * (value - moments.mean);
  moments.standard_deviation = std::sqrt(squares / (n - 1));
  moments.standard_error = moments.standard_deviation / std::sqrt(n);
  return moments;
}

double StudentQuantile975(int degrees) {
  if (degrees < 4) return kNotKnown;
  constexpr double x = 1.959963984540054;  // of the normal distribution
  const double n = degrees, x2 = x * x;
  const double g1 = x * (x2 + 1) / 4;
  const double g2 = x * ((5 * x2 + 16) * x2 + 3) / 96;
  const double g3 = x * (((3 * x2 + 19) * x2 + 17) * x2 - 15) / 384;
  const double g4 = x * ((((79 * x2 + 776) * x2 + 1482) * x2 - 1920) * x2 - 945) / 92160;
  return x + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n;
}

double GrowthOf(const std::vector<std::pair<double, double>>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [size, value] : points) {
    if (size <= 0 || value <= 0) continue;
    const double a = std::log(size), b = std::log(value);
    n += 1, x += a, y += b, xx += a * a, xy += a * b;
  }
  const double spread = n * xx - x * x;
  return n < 2 || spread < 1e-9 ? kNotKnown : (n * xy - x * y) / spread;
}

}  // namespace muster::tools
