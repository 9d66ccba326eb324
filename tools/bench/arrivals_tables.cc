#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "scheduler/policies/registry.h"
#include "tools/bench/arrivals_suite.h"

namespace muster::tools {
namespace {

/// Of a mission; NaN: nothing to tell, as there were no such tasks.
using Metric = std::function<double(const Service&)>;

double Percent(double part, double all) { return all > 0 ? 100 * part / all : std::nan(""); }

double WorthPercent(const Service& s) { return Percent(s.worth_done, s.worth_all); }
double OnTimePercent(const Service& s) { return Percent(s.on_time(), s.reported()); }
double LateResponseMin(const Service& s) { return s.response_quantile_s(0.9) / 60; }

struct Mean {
  double of = 0;
  double error = 0;  ///< standard error; NaN: fewer than two values
};

/// Of those that are numbers; no value: none is.
std::optional<Mean> MeanOf(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return std::nullopt;
  const auto n = static_cast<double>(values.size());
  Mean mean;
  for (const double value : values) mean.of += value / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean.of) * (value - mean.of);
  mean.error = n > 1 ? std::sqrt(squares / (n - 1) / n) : std::nan("");
  return mean;
}

template <class T>
void AddOnce(const T& item, std::vector<T>* list) {
  if (std::find(list->begin(), list->end(), item) == list->end()) list->push_back(item);
}

/// The rows by mission and policy, each in the order in which they came.
class Grid {
 public:
  explicit Grid(const std::vector<ArrivalsRow>& rows) : rows_(rows) {
    for (const ArrivalsRow& row : rows) {
      AddOnce({row.arrivals, row.load}, &lines);
      AddOnce(row.arrivals, &arrivals);
      AddOnce(row.policy, &policies);
    }
    reference =
        std::find(policies.begin(), policies.end(), scheduler::kDefaultPolicy) == policies.end()
            ? (policies.empty() ? "" : policies.front())
            : std::string(scheduler::kDefaultPolicy);
  }

  /// Of that line and policy, seed by seed.
  std::vector<double> Values(const std::pair<std::string, double>& line, const std::string& policy,
                             const Metric& metric) const {
    std::vector<double> values;
    for (const ArrivalsRow& row : rows_) {
      if (row.arrivals == line.first && row.load == line.second && row.policy == policy) {
        values.push_back(metric(row.service));
      }
    }
    return values;
  }

  std::vector<std::pair<std::string, double>> lines;  ///< arrivals, load
  std::vector<std::string> arrivals, policies;
  std::string reference;  ///< policy that the others are compared with

 private:
  const std::vector<ArrivalsRow>& rows_;
};

std::string MeanCell(const std::vector<double>& values, int digits) {
  const auto mean = MeanOf(values);
  return mean ? fmt::format("{:.{}f}", mean->of, digits) : "";
}

/// "(-13.3 ± 1.1)": the mean of the differences, both lists by seed.
std::string DifferenceCell(std::vector<double> values, const std::vector<double>& reference) {
  for (std::size_t i = 0; i < values.size() && i < reference.size(); ++i) values[i] -= reference[i];
  const auto mean = MeanOf(values);
  if (!mean) return "";
  return std::isnan(mean->error) ? fmt::format(" ({:+.1f})", mean->of)
                                 : fmt::format(" ({:+.1f} ± {:.1f})", mean->of, mean->error);
}

/// A table with one cell for each line and policy.
std::string TableOf(const Grid& grid, const std::string& title,
                    const std::function<std::string(const std::pair<std::string, double>&,
                                                    const std::string&)>& cell) {
  std::string text = title + "\n\n| arrivals | load |";
  for (const std::string& policy : grid.policies) text += fmt::format(" `{}` |", policy);
  text += "\n| --- | --- |";
  for (std::size_t i = 0; i < grid.policies.size(); ++i) text += " --- |";
  text += "\n";
  for (const auto& line : grid.lines) {
    text += fmt::format("| {} | {} |", line.first, line.second);
    for (const std::string& policy : grid.policies) text += " " + cell(line, policy) + " |";
    text += "\n";
  }
  return text;
}

std::string Compared(const Grid& grid, const std::string& title, const Metric& metric) {
  return TableOf(grid, title, [&](const auto& line, const std::string& policy) {
    const auto values = grid.Values(line, policy, metric);
    std::string cell = MeanCell(values, 1);
    if (policy != grid.reference) {
      cell += DifferenceCell(values, grid.Values(line, grid.reference, metric));
    }
    return cell;
  });
}

}  // namespace

std::string SummaryOf(const std::vector<ArrivalsRow>& rows) {
  const Grid grid(rows);
  std::string text = Compared(grid, "worth done, %", &WorthPercent);
  text += "\n" + Compared(grid, "sensed on time, %", &OnTimePercent);
  text += "\n" + TableOf(grid, "on time of low, normal, high priority and emergencies, %",
                         [&](const auto& line, const std::string& policy) {
                           std::string cell;
                           for (std::size_t p = 0; p < kPriorities; ++p) {
                             const auto on_time = [p](const Service& s) {
                               return Percent(s.by_priority[p].on_time, s.by_priority[p].reported);
                             };
                             cell += (p == 0 ? "" : ", ") +
                                     MeanCell(grid.Values(line, policy, on_time), 0);
                           }
                           return cell;
                         });
  text += "\n" + Compared(grid, "90th percentile of the response, min", &LateResponseMin);
  return text;
}

std::string ArrivalsPlot(const std::vector<ArrivalsRow>& rows, const std::string& svg_file) {
  const Grid grid(rows);
  const std::size_t columns = grid.arrivals.size() < 3 ? grid.arrivals.size() : 3;
  const std::size_t lines = columns == 0 ? 0 : (grid.arrivals.size() + columns - 1) / columns;
  std::string text = fmt::format(
      "set terminal svg size {},{} noenhanced background 'white'\nset output '{}'\n"
      "set multiplot layout {},{}\nset xlabel 'load'\nset ylabel 'share of the worth'\n"
      "set xrange [0:*]\nset yrange [0:1]\nset key bottom left samplen 1.5 spacing 0.8\n",
      420 * columns, 380 * lines, svg_file, lines, columns);
  for (std::size_t a = 0; a < grid.arrivals.size(); ++a) {
    std::string plot;
    for (std::size_t i = 0; i < grid.policies.size(); ++i) {
      text += fmt::format("$of_{}_{} << EOD\n", a, i);
      for (const auto& line : grid.lines) {
        const auto mean = MeanOf(grid.Values(line, grid.policies[i], &WorthPercent));
        if (line.first != grid.arrivals[a] || !mean) continue;
        text += fmt::format("{} {:.4f}\n", line.second, mean->of / 100);
      }
      text += "EOD\n";
      plot += fmt::format("{}$of_{}_{} with linespoints title '{}'", i == 0 ? "" : ", ", a, i,
                          grid.policies[i]);
    }
    text += fmt::format("set title '{}'\nplot {}\n", grid.arrivals[a], plot);
  }
  return text + "unset multiplot\n";
}

}  // namespace muster::tools
