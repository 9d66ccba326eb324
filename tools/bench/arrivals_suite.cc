#include "tools/bench/arrivals_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/check.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"

namespace muster::tools {
namespace {

constexpr const char* kDrawnArrivals[] = {"steady", "bursts"};
constexpr int kBursts = 6;

/// The more a task matters, the sooner it is due; twice that long after its report it is gone.
void AddTimes(GeneratorSettings* settings) {
  settings->priority_shares = {0.3, 0.4, 0.2, 0.1};
  constexpr double kDue_min[] = {60, 40, 25, 15};
  for (std::size_t p = 0; p < kPriorities; ++p) {
    settings->due_min[p] = Always(kDue_min[p]);
    settings->expires_min[p] = Always(2 * kDue_min[p]);
  }
}

int TasksAt(double load, int tasks) {
  return std::max(1, static_cast<int>(std::lround(tasks * load)));
}

/// Nine of ten tasks are reported while the mission runs.
Scenario Drawn(const std::string& arrivals, double load, std::uint64_t seed) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.tasks = TasksAt(load, settings.tasks);
  settings.arrivals = {0.9, arrivals == "bursts" ? kBursts : 0};
  AddTimes(&settings);
  return Generate(settings, seed);
}

/// As many rows of the data set as the load says, each reported at its own time.
Scenario OfRows(ImportedSettings* imported, const std::string& name, double load,
                std::uint64_t seed) {
  GeneratorSettings settings = ImportedSettings::ShapeOf(name);
  settings.tasks = TasksAt(load, settings.tasks);
  AddTimes(&settings);
  Scenario scenario = imported->Make(name, settings, seed, true);
  if (static_cast<int>(scenario.tasks.size()) < settings.tasks) {
    throw InputError("command line", "--loads", fmt::to_string(load),
                     fmt::format("less: {} has {} rows in the mission's time, not {}", name,
                                 scenario.tasks.size(), settings.tasks));
  }
  return scenario;
}

}  // namespace

std::vector<std::string> ArrivalsInstances(bool has_data) {
  std::vector<std::string> names(std::begin(kDrawnArrivals), std::end(kDrawnArrivals));
  for (const std::string& name : ImportedSettings::Names()) {
    if (has_data) names.push_back(name);
  }
  return names;
}

Scenario ArrivalsScenario(ImportedSettings* imported, const std::string& arrivals, double load,
                          std::uint64_t seed) {
  return ImportedSettings::Has(arrivals) ? OfRows(imported, arrivals, load, seed)
                                         : Drawn(arrivals, load, seed);
}

void RunArrivals(const BenchOptions& options,
                 const std::function<void(const ArrivalsRow&)>& report) {
  ImportedSettings imported(options.data);
  // Missions that cannot be flown are refused before the first one starts.
  for (const std::string& arrivals : options.instances) {
    for (const double load : options.loads) {
      ArrivalsScenario(&imported, arrivals, load, static_cast<std::uint64_t>(options.first_seed));
    }
  }
  for (const std::string& arrivals : options.instances) {
    for (const double load : options.loads) {
      for (const std::uint64_t seed : options.AllSeeds()) {
        const ScenarioText text = TextOf(ArrivalsScenario(&imported, arrivals, load, seed));
        for (const std::string& policy : options.methods) {
          RunRecord record;
          Simulate(text, policy, [&](const Packet& packet) { record.Add(packet); });
          report({arrivals, load, seed, policy, ServiceOf(record, *record.scenario())});
        }
      }
    }
  }
}

std::string ArrivalsCsvHeader() {
  return "arrivals,load,seed,policy,reported,done,on_time,expired,worth_done,worth_all,"
         "mean_response_s,median_response_s,p90_response_s,low,low_on_time,normal,normal_on_time,"
         "high,high_on_time,emergencies,emergencies_on_time\n";
}

std::string ToCsv(const ArrivalsRow& row) {
  const Service& s = row.service;
  std::string line = fmt::format(
      "{},{},{},{},{},{},{},{},{},{},{:.3f},{:.3f},{:.3f}", row.arrivals, row.load, row.seed,
      row.policy, s.reported(), s.done(), s.on_time(), s.expired, s.worth_done, s.worth_all,
      s.mean_response_s(), s.response_quantile_s(0.5), s.response_quantile_s(0.9));
  for (const Service::Of& of : s.by_priority) {
    fmt::format_to(std::back_inserter(line), ",{},{}", of.reported, of.on_time);
  }
  return line + "\n";
}

}  // namespace muster::tools
