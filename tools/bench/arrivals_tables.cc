#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "scheduler/policies/registry.h"
#include "tools/bench/arrivals_suite.h"
#include "tools/bench/plot.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"

namespace muster::tools {
namespace {

/// A figure of a mission; kNotKnown where it had no such tasks.
using Metric = std::function<double(const Service&)>;

double Percent(double part, double all) { return all > 0 ? 100 * part / all : kNotKnown; }

double WorthPercent(const Service& s) { return Percent(s.worth_done, s.worth_all); }
double OnTimePercent(const Service& s) { return Percent(s.on_time(), s.reported()); }
double LateResponseMin(const Service& s) { return s.response_quantile_s(0.9) / 60; }

using ArrivalsLine = std::pair<std::string, double>;  ///< arrivals, load
using RowsOfLine = std::vector<const ArrivalsRow*>;

/// The rows by mission and policy, each in the order in which they came.
struct Grid {
  explicit Grid(const std::vector<ArrivalsRow>& rows)
      : lines(GroupsOf(
            rows, [](const ArrivalsRow& row) { return ArrivalsLine(row.arrivals, row.load); })) {
    for (const auto& group : GroupsOf(rows, [](const ArrivalsRow& row) { return row.policy; })) {
      policies.push_back(group.first);
      if (group.first == scheduler::kDefaultPolicy) reference = group.first;
    }
    if (reference.empty() && !policies.empty()) reference = policies.front();
  }

  std::vector<std::pair<ArrivalsLine, RowsOfLine>> lines;
  std::vector<std::string> policies;
  std::string reference;  ///< policy that the others are compared with
};

/// What a policy made of the missions, seed by seed.
std::vector<double> ValuesBy(const std::string& policy, RowsOfLine missions, const Metric& metric) {
  std::erase_if(missions, [&](const ArrivalsRow* row) { return row->policy != policy; });
  return ValuesOf(missions, [&](const ArrivalsRow& row) { return metric(row.service); });
}

std::string MeanCell(const std::vector<double>& values, int digits) {
  const Moments moments = MomentsOf(values);
  return moments.n > 0 ? fmt::format("{:.{}f}", moments.mean, digits) : "";
}

/// "(-13.3 ± 1.1)": the mean of the differences, both lists by seed.
std::string DifferenceCell(std::vector<double> values, const std::vector<double>& reference) {
  for (std::size_t i = 0; i < values.size() && i < reference.size(); ++i) values[i] -= reference[i];
  const Moments moments = MomentsOf(values);
  if (moments.n == 0) return "";
  return moments.n == 1 ? fmt::format(" ({:+.1f})", moments.mean)
                        : fmt::format(" ({:+.1f} ± {:.1f})", moments.mean, moments.standard_error);
}

/// A table with one cell for each line and policy.
std::string TableOf(const Grid& grid, const std::string& title,
                    const std::function<std::string(const RowsOfLine&, const std::string&)>& cell) {
  std::string columns = "arrivals|load";
  for (const std::string& policy : grid.policies) columns += "|`" + policy + "`";
  Sheet sheet(columns);
  for (const auto& [line, missions] : grid.lines) {
    std::string cells = fmt::format("{}|{}", line.first, line.second);
    for (const std::string& policy : grid.policies) cells += "|" + cell(missions, policy);
    sheet.Add(cells);
  }
  return title + "\n\n" + sheet.Markdown();
}

std::string Compared(const Grid& grid, const std::string& title, const Metric& metric) {
  return TableOf(grid, title, [&](const RowsOfLine& missions, const std::string& policy) {
    const auto values = ValuesBy(policy, missions, metric);
    std::string cell = MeanCell(values, 1);
    if (policy != grid.reference) {
      cell += DifferenceCell(values, ValuesBy(grid.reference, missions, metric));
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
                         [&](const RowsOfLine& missions, const std::string& policy) {
                           std::string cell;
                           for (std::size_t p = 0; p < kPriorities; ++p) {
                             const auto on_time = [p](const Service& s) {
                               return Percent(s.by_priority[p].on_time, s.by_priority[p].reported);
                             };
                             cell += (p == 0 ? "" : ", ") +
                                     MeanCell(ValuesBy(policy, missions, on_time), 0);
                           }
                           return cell;
                         });
  text += "\n" + Compared(grid, "90th percentile of the response, min", &LateResponseMin);
  return text;
}

std::string ArrivalsPlot(const std::vector<ArrivalsRow>& rows, const std::string& svg_file) {
  const Grid grid(rows);
  Plot plot;
  const auto groups = GroupsOf(rows, [](const ArrivalsRow& row) { return row.arrivals; });
  for (const auto& group : groups) {
    Chart& chart = plot.charts.emplace_back();
    chart.settings = fmt::format("set title '{}'\n", group.first);
    for (const std::string& policy : grid.policies) {
      Curve curve{"", "with linespoints", policy};
      for (const auto& [line, missions] : grid.lines) {
        const Moments moments = MomentsOf(ValuesBy(policy, missions, &WorthPercent));
        if (line.first != group.first || moments.n == 0) continue;
        curve.points += fmt::format("{} {:.4f}\n", line.second, moments.mean / 100);
      }
      if (!curve.points.empty()) chart.curves.push_back(curve);
    }
  }
  const int n = static_cast<int>(plot.charts.size());
  plot.columns = std::clamp(n, 1, 3);
  plot.width = 420 * plot.columns;
  plot.height = 380 * ((n + plot.columns - 1) / plot.columns);
  plot.settings =
      "set xlabel 'load'\nset ylabel 'share of the worth'\nset xrange [0:*]\nset yrange [0:1]\n"
      "set key bottom left samplen 1.5 spacing 0.8\n";
  return ScriptOf(plot, svg_file);
}

}  // namespace muster::tools
