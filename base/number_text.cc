#include "base/number_text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace muster {
namespace {

/// The shortest text that `back` turns into the value again.
template <class Back>
std::string ShortestText(long double in_unit, const Back& back) {
  std::string text = fmt::to_string(static_cast<double>(in_unit));
  for (int digits = 16; digits <= 21 && !back(text); ++digits) {
    text = fmt::format("{:.{}g}", in_unit, digits);
  }
  return text;
}

}  // namespace

double FromText(const std::string& text, Unit unit) {
  const long double amount = std::strtold(text.c_str(), nullptr);
  return static_cast<double>(amount * unit.numerator / unit.denominator) + 0.0;  // -0 becomes 0
}

std::string ToText(double value, Unit unit) {
  if (!std::isfinite(value)) return fmt::to_string(value);
  return ShortestText((static_cast<long double>(value) + 0.0L) * unit.denominator / unit.numerator,
                      [&](const std::string& text) { return FromText(text, unit) == value; });
}

TimeUs TimeFromText(const std::string& text, long double unit_us) {
  return static_cast<TimeUs>(std::llroundl(std::strtold(text.c_str(), nullptr) * unit_us));
}

std::string TimeToText(TimeUs value, long double unit_us) {
  return ShortestText(static_cast<long double>(value) / unit_us, [&](const std::string& text) {
    return TimeFromText(text, unit_us) == value;
  });
}

}  // namespace muster
