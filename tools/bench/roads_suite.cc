#include "tools/bench/roads_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/check.h"
#include "base/random.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/bench/sheet.h"
#include "tools/bench/statistics.h"
#include "tools/record/service.h"

namespace muster::tools {
namespace {

constexpr double kClosedRadius_m = 150;
constexpr std::string_view kWithoutRoads = "-without-roads";

std::int64_t LengthOf(const Roads& roads, const Road& road) {
  std::int64_t mm = 0;
  for (std::size_t i = 1; i < road.points.size(); ++i) {
    mm += LengthMm(roads.points[static_cast<std::size_t>(road.points[i - 1])],
                   roads.points[static_cast<std::size_t>(road.points[i])]);
  }
  return mm;
}

Scenario WithoutRoads(Scenario scenario) {
  scenario.roads = nullptr;
  scenario.ways = DefaultWays();
  return scenario;
}

RoadsRow Fly(const ClosedMission& mission, RoadsRow row) {
  RunRecord record;
  Simulate(TextOf(mission.scenario), row.policy, [&](const Packet& packet) { record.Add(packet); },
           {{}, mission.hidden});
  const Service service = ServiceOf(record, *record.scenario());
  row.tasks = service.reported();
  row.done = service.done();
  return row;
}

void FlyAll(const Scenario& scenario, const std::vector<double>& closed_percent, RoadsRow row,
            const std::function<void(const RoadsRow&)>& report) {
  report(Fly({scenario, {}}, row));
  row.ways = "straight";
  report(Fly({WithoutRoads(scenario), {}}, row));
  for (const double percent : closed_percent) {
    const std::vector<ClosedPlace> places = DrawClosedPlaces(scenario, percent);
    row.closed_percent = percent;
    for (const bool known : {true, false}) {
      row.ways = known ? "known" : "unknown";
      report(Fly(WithClosedRoads(scenario, places, known), row));
    }
  }
}

/// Percentages by seed.
using BySeed = std::map<std::uint64_t, double>;

BySeed PercentOf(const std::vector<RoadsRow>& rows, const RoadsRow& like) {
  BySeed percent;
  for (const RoadsRow& row : rows) {
    if (row.places == like.places && row.policy == like.policy && row.ways == like.ways &&
        row.closed_percent == like.closed_percent) {
      percent[row.seed] = row.percent();
    }
  }
  return percent;
}

std::string MeanCell(const BySeed& of) {
  std::vector<double> values;
  for (const auto& [seed, value] : of) values.push_back(value);
  const Moments moments = MomentsOf(std::move(values));
  return moments.n > 0 ? fmt::format("{:.1f}", moments.mean) : "";
}

/// "-13.3 ± 1.1": of the seeds that both have.
std::string DifferenceCell(const BySeed& of, const BySeed& to) {
  std::vector<double> values;
  for (const auto& [seed, value] : of) {
    if (const auto other = to.find(seed); other != to.end()) {
      values.push_back(value - other->second);
    }
  }
  const Moments moments = MomentsOf(std::move(values));
  if (moments.n == 0) return "";
  return moments.n == 1 ? fmt::format("{:+.1f}", moments.mean)
                        : fmt::format("{:+.1f} ± {:.1f}", moments.mean, moments.standard_error);
}

/// A way to travel that rows have, "by road" first: how it is called, and a row like it.
std::vector<std::pair<std::string, RoadsRow>> ColumnsOf(const std::vector<RoadsRow>& rows) {
  std::vector<std::pair<std::string, RoadsRow>> columns;
  const auto key = [](const RoadsRow& row) { return std::pair(row.ways, row.closed_percent); };
  for (const auto& [of, group] : GroupsOf(rows, key)) {
    const std::string name = of.first == "road" ? "by road"
                             : of.first == "straight"
                                 ? "in straight lines"
                                 : fmt::format("{} % closed, {}", of.second, of.first);
    columns.emplace_back(name, *group.front());
  }
  return columns;
}

std::string RowsTable(const std::vector<RoadsRow>& rows, bool of_ablation) {
  const auto columns = ColumnsOf(rows);
  std::string names = "places|policy";
  for (const auto& [name, row] : columns) {
    if (of_ablation && row.ways == "straight") continue;
    names += fmt::format("|{}{}", name, row.ways == "road" && !of_ablation ? ", %" : "");
  }
  Sheet sheet(names);
  bool any = false;
  const auto key = [](const RoadsRow& row) { return std::pair(row.places, row.policy); };
  for (const auto& [of, group] : GroupsOf(rows, key)) {
    const bool is_ablation = of.second.ends_with(kWithoutRoads);
    if (of_ablation && !is_ablation) continue;
    any = true;
    const std::string knows =
        is_ablation ? of.second.substr(0, of.second.size() - kWithoutRoads.size()) : of.second;
    std::string cells = fmt::format("{}|`{}`", of.first, of_ablation ? knows : of.second);
    RoadsRow by_road;
    by_road.places = of.first;
    by_road.policy = of.second;
    for (const auto& [name, column] : columns) {
      if (of_ablation && column.ways == "straight") continue;
      RoadsRow like = column;
      like.places = of.first;
      like.policy = of.second;
      RoadsRow reference = of_ablation ? like : by_road;
      if (of_ablation) reference.policy = knows;
      cells += "|" + (like.ways == "road" && !of_ablation
                          ? MeanCell(PercentOf(rows, like))
                          : DifferenceCell(PercentOf(rows, like), PercentOf(rows, reference)));
    }
    sheet.Add(cells);
  }
  return any ? sheet.Markdown() : "";
}

}  // namespace

std::vector<ClosedPlace> DrawClosedPlaces(const Scenario& scenario, double percent) {
  const Roads& roads = *scenario.roads->network;
  std::int64_t all_mm = 0, closed_mm = 0;
  for (const Road& road : roads.roads) all_mm += LengthOf(roads, road);
  std::vector<bool> closed(roads.roads.size());
  std::vector<ClosedPlace> places;
  Random random(scenario.seed, Stream::kClosures);
  while (100 * static_cast<double>(closed_mm) < percent * static_cast<double>(all_mm)) {
    const RoadPoint at =
        roads.points[random.Below(static_cast<std::uint32_t>(roads.points.size()))];
    ClosedPlace place;
    place.circle = {ToPoint(at), kClosedRadius_m};
    const TimeUs half_us = scenario.rules.limit_us / 2;
    place.from_us = static_cast<TimeUs>(random.Uniform() * static_cast<double>(half_us)) /
                    kSecondUs * kSecondUs;
    for (const std::int32_t road : RoadsIn(roads, {place.circle})) {
      const auto i = static_cast<std::size_t>(road);
      if (!closed[i]) closed_mm += LengthOf(roads, roads.roads[i]);
      closed[i] = true;
    }
    places.push_back(place);
  }
  return places;
}

ClosedMission WithClosedRoads(const Scenario& scenario, const std::vector<ClosedPlace>& places,
                              bool known) {
  ClosedMission mission{scenario, {}};
  if (!known) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      mission.hidden.push_back(
          {RoadArea{places[i].circle}, places[i].from_us, kNever, fmt::format("closed{}", i)});
    }
    return mission;
  }
  ScenarioRoads roads = *scenario.roads;
  for (const ClosedPlace& place : places) {
    roads.closures.push_back({{place.circle}, "", place.from_us, kNever});
  }
  const std::string file = roads.file;
  UseRoads(std::move(roads), file, &mission.scenario);
  return mission;
}

void RunRoads(const BenchOptions& options, const std::function<void(const RoadsRow&)>& report) {
  std::vector<Scenario> scenarios;
  for (const std::string& file : options.scenarios) {
    scenarios.push_back(LoadScenario(file));
    if (!scenarios.back().roads) throw InputError(file, "roads", "none", "a scenario with roads");
  }
  for (const Scenario& scenario : scenarios) {
    for (const std::string& policy : options.methods) {
      RoadsRow row;
      row.places = scenario.name;
      row.seed = scenario.seed;
      row.policy = policy;
      FlyAll(scenario, options.closed_percent, row, report);
    }
  }
}

std::string RoadsCsvHeader() { return "places,seed,ways,closed_percent,policy,tasks,done\n"; }

std::string ToCsv(const RoadsRow& row) {
  return fmt::format("{},{},{},{},{},{},{}\n", row.places, row.seed, row.ways, row.closed_percent,
                     row.policy, row.tasks, row.done);
}

std::string SummaryOf(const std::vector<RoadsRow>& rows) {
  std::string text = "tasks done, %, and differences to the same scenarios by road\n\n";
  text += RowsTable(rows, false);
  if (const std::string ablation = RowsTable(rows, true); !ablation.empty()) {
    text +=
        "\nplanned in straight lines, less the same policy that knows the roads, %\n\n" + ablation;
  }
  return text;
}

}  // namespace muster::tools
