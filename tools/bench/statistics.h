#pragma once

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

namespace muster::tools {

/// A figure that is not known.
inline constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

/// The rows of each key, keys in the order in which they come first.
template <class Row, class KeyOf>
auto GroupsOf(const std::vector<Row>& rows, const KeyOf& key_of) {
  using Key = std::decay_t<decltype(key_of(rows.front()))>;
  std::vector<std::pair<Key, std::vector<const Row*>>> groups;
  for (const Row& row : rows) {
    const Key key = key_of(row);
    auto at = std::find_if(groups.begin(), groups.end(),
                           [&](const auto& group) { return group.first == key; });
    if (at == groups.end()) at = groups.insert(at, {key, {}});
    at->second.push_back(&row);
  }
  return groups;
}

/// A value of each row.
template <class Row, class ValueOf>
std::vector<double> ValuesOf(const std::vector<const Row*>& rows, const ValueOf& value_of) {
  std::vector<double> values;
  for (const Row* row : rows) values.push_back(static_cast<double>(value_of(*row)));
  return values;
}

// Values that are not known are left out of all that follows.

/// The value of that rank, the nearest one: 0 the least, 0.5 the median, 1 the largest. kNotKnown
/// without values.
double Quantile(std::vector<double> values, double rank);

/// How many percent of the values are at most `most`; kNotKnown without values.
double PercentUpTo(double most, const std::vector<double>& values);

struct Moments {
  int n = 0;
  double mean = 0;
  double standard_deviation = 0;  ///< 0 with fewer than two values
  double standard_error = 0;      ///< of the mean; 0 with fewer than two values
};
Moments MomentsOf(std::vector<double> values);

/// The value that Student's t with so many degrees of freedom is below in 97.5 of 100 cases, to
/// 0.002; kNotKnown with fewer than 4. Source: Abramowitz and Stegun, Handbook of Mathematical
/// Functions, 26.7.5.
double StudentQuantile975(int degrees);

/// The power of the first number by which the second one grows: least squares in logarithms.
/// kNotKnown with fewer than two different first numbers.
double GrowthOf(const std::vector<std::pair<double, double>>& points);

}  // namespace muster::tools
