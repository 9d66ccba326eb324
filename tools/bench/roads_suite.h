#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/scenario.h"
#include "tools/bench/suites.h"
#include "world/hidden_closures.h"

namespace muster::tools {

/// One mission of the suite, flown in virtual time.
struct RoadsRow {
  std::string places;  ///< the scenario's name
  std::uint64_t seed = 0;
  /// "road"; "straight": the same places without roads; "known", "unknown": by road, while roads
  /// are closed.
  std::string ways = "road";
  double closed_percent = 0;  ///< of the length of all roads, at least
  std::string policy;
  int tasks = 0;
  int done = 0;

  double percent() const { return tasks > 0 ? 100.0 * done / tasks : 0; }
};

/// A place where all roads nearby are closed, from a time on until the mission ends.
struct ClosedPlace {
  RoadArea::Circle circle;
  TimeUs from_us = 0;
};

/// Places drawn at points of the scenario's roads until at least `percent` of the length of all
/// roads is closed; each closes at a time drawn from the first half of the mission. A function of
/// the scenario and its seed; a higher percentage begins with the places of a lower one.
std::vector<ClosedPlace> DrawClosedPlaces(const Scenario& scenario, double percent);

/// The same mission with these closures: known, by the scenario's own `closures`, so that all know
/// of each as it begins; or unknown, by faults, so that it has to be found out.
struct ClosedMission {
  Scenario scenario;
  std::vector<world::HiddenClosure> hidden;
};
ClosedMission WithClosedRoads(const Scenario& scenario, const std::vector<ClosedPlace>& places,
                              bool known);

/// Flies each scenario with each policy: by road, in straight lines, and with `closed_percent` of
/// the roads closed, known and unknown. Of the options: methods, scenarios, closed_percent. Throws
/// InputError, before the first mission, where a scenario has no roads.
void RunRoads(const BenchOptions& options, const std::function<void(const RoadsRow&)>& report);

std::string RoadsCsvHeader();
std::string ToCsv(const RoadsRow& row);

/// A Markdown table of tasks done, in percent: a row for each places and policy. By road it has the
/// mean over the seeds; of all else the mean of the differences, seed by seed, to the same
/// scenarios by road, and its standard error. A second table has what policies lose that do not
/// know of roads, where both were flown.
std::string SummaryOf(const std::vector<RoadsRow>& rows);

}  // namespace muster::tools
