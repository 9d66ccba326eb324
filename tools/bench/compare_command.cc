#include "tools/bench/compare_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "scheduler/policies/registry.h"
#include "simulation/simulator.h"
#include "tools/bench/statistics.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/host/worker_pool.h"
#include "tools/record/run_record.h"
#include "tools/record/service.h"
#include "tools/scenario/settings_options.h"

namespace muster::tools {
namespace {

using OrderedJson = nlohmann::ordered_json;

struct NamedScenario {
  std::string name;
  Scenario scenario;
};

/// Percent of the mission's tasks.
double Completion(const ComparedMission& mission) {
  return mission.tasks == 0 ? 100 : 100.0 * mission.done / mission.tasks;
}

struct Difference {
  Moments points;                        ///< of completion, in percent of the tasks
  int more = 0, as_many = 0, fewer = 0;  ///< missions
  std::optional<double> low, high;       ///< none: too few missions
  bool may_be_chance() const { return !low || (*low <= 0 && *high >= 0); }
};

Difference Compare(const std::vector<ComparedMission>& a, const std::vector<ComparedMission>& b) {
  Difference difference;
  std::vector<double> points;
  for (std::size_t i = 0; i < a.size(); ++i) {
    points.push_back(Completion(b[i]) - Completion(a[i]));
    difference.more += b[i].done > a[i].done;
    difference.as_many += b[i].done == a[i].done;
    difference.fewer += b[i].done < a[i].done;
  }
  difference.points = MomentsOf(points);
  const double half =
      StudentQuantile975(difference.points.n - 1) * difference.points.standard_error;
  if (!std::isnan(half)) {
    difference.low = difference.points.mean - half;
    difference.high = difference.points.mean + half;
  }
  return difference;
}

/// What is the same for all missions of a policy.
struct Total {
  int done = 0, tasks = 0;
  double response_s = 0, decision_s = 0;
};

Total TotalOf(const std::vector<ComparedMission>& missions) {
  Total total;
  std::vector<double> responses, decisions;
  for (const ComparedMission& mission : missions) {
    total.done += mission.done;
    total.tasks += mission.tasks;
    responses.push_back(mission.response_s);
    decisions.push_back(mission.decision_s);
  }
  total.response_s = MomentsOf(responses).n == 0 ? kNotKnown : MomentsOf(responses).mean;
  total.decision_s = Quantile(decisions, 0.5);
  return total;
}

std::string DifferenceText(const std::string& policy, const std::string& base,
                           const Difference& difference) {
  const std::string interval =
      difference.low
          ? fmt::format("95 % interval {:+.1f} to {:+.1f}{}", *difference.low, *difference.high,
                        difference.may_be_chance() ? ": may be chance" : "")
          : "too few missions to say whether that is chance";
  return fmt::format(
      "{} against {}: {:+.1f} points of completion ({}). It does more tasks in {} of {} missions, "
      "as many in {}, fewer in {}.\n",
      policy, base, difference.points.mean, interval, difference.more, difference.points.n,
      difference.as_many, difference.fewer);
}

Options CompareOptions() {
  Options options(
      "muster compare",
      "Simulates the same missions with several policies and says which does more tasks, and "
      "whether that may be chance. The missions are drawn, one for each seed, or files.");
  options.Add("policies", "POLICY,...", "Policies; also without --policies").List();
  options.RestBelongsTo("policies");
  options.Add("seeds", "N", "Missions to draw").Integer(1, 10'000).Default(20);
  options.Add("first-seed", "N", "Seed of the first").Integer(1, 1'000'000'000).Default(1);
  options.Add("scenarios", "FILE,...", "Missions of these files instead of drawn ones").List();
  options.Add("preset", "NAME", "Data set of the paper to draw from (muster scenario --list)")
      .Default("Random_1");
  options.Add("jobs", "N", "Missions at a time").Integer(1, 1024).Default(2);
  options.Json();
  options.Quiet();
  AddNumberOptions(&options);
  return options;
}

std::vector<NamedScenario> ScenariosOf(const Arguments& arguments, std::string* title) {
  std::vector<NamedScenario> scenarios;
  if (arguments.Has("scenarios")) {
    for (const std::string& file : arguments.All("scenarios")) {
      scenarios.push_back({file, LoadScenario(file)});
    }
    *title = fmt::format("{}", fmt::join(arguments.All("scenarios"), ", "));
    return scenarios;
  }
  const GeneratorSettings settings = SettingsFrom(arguments, PresetByName(arguments.Get("preset")));
  const auto first = arguments.Get<std::int64_t>("first-seed");
  const int n = arguments.Get<int>("seeds");
  for (std::int64_t seed = first; seed < first + n; ++seed) {
    Scenario scenario = Generate(settings, static_cast<std::uint64_t>(seed));
    ValidateScenario(scenario, "command line");
    scenarios.push_back({fmt::format("seed {}", seed), std::move(scenario)});
  }
  *title = fmt::format("{}, seeds {} to {}", settings.name, first, first + n - 1);
  return scenarios;
}

/// One mission after another with each policy, for the other process to read.
std::string Fly(const NamedScenario& named, const std::vector<std::string>& policies) {
  const ScenarioText text = TextOf(named.scenario);
  OrderedJson rows = OrderedJson::array();
  for (const std::string& policy : policies) {
    RunRecord record;
    Simulate(text, policy, [&](const Packet& packet) { record.Add(packet); });
    const Service service = ServiceOf(record, *record.scenario());
    std::vector<double> took_s;
    for (const auto& [index, schedule] : record.schedules()) {
      took_s.push_back(ToSeconds(schedule.solve_us));
    }
    rows.push_back({{"done", service.done()},
                    {"tasks", service.reported()},
                    {"response_s", service.mean_response_s()},
                    {"decision_s", Quantile(took_s, 0.5)}});
  }
  return rows.dump();
}

/// null is what JSON makes of a number that is not known.
double NumberOf(const OrderedJson& value) {
  return value.is_number() ? value.get<double>() : kNotKnown;
}

}  // namespace

std::string ComparisonText(const Comparison& comparison) {
  std::string text = fmt::format("{:<24} {:>14} {:>7} {:>10} {:>12}\n", "policy", "done", "%",
                                 "response", "decision");
  for (std::size_t p = 0; p < comparison.policies.size(); ++p) {
    const Total total = TotalOf(comparison.missions[p]);
    text += fmt::format(
        "{:<24} {:>14} {:>7.1f} {:>10} {:>12}\n", comparison.policies[p],
        fmt::format("{} of {}", total.done, total.tasks),
        total.tasks == 0 ? 100 : 100.0 * total.done / total.tasks,
        std::isnan(total.response_s) ? "-" : fmt::format("{:.1f} min", total.response_s / 60),
        fmt::format("{:.1f} ms", 1000 * total.decision_s));
  }
  for (std::size_t p = 1; p < comparison.policies.size(); ++p) {
    text += DifferenceText(comparison.policies[p], comparison.policies[0],
                           Compare(comparison.missions[0], comparison.missions[p]));
  }
  return text;
}

OrderedJson ToJson(const Comparison& comparison) {
  OrderedJson json = {{"version", 1}, {"policies", OrderedJson::array()}};
  for (std::size_t p = 0; p < comparison.policies.size(); ++p) {
    const std::vector<ComparedMission>& missions = comparison.missions[p];
    OrderedJson of = {{"policy", comparison.policies[p]}, {"missions", OrderedJson::array()}};
    for (const ComparedMission& mission : missions) {
      of["missions"].push_back({{"mission", mission.mission},
                                {"tasks_done", mission.done},
                                {"tasks_total", mission.tasks},
                                {"mean_response_s", mission.response_s},
                                {"decision_median_s", mission.decision_s}});
    }
    if (p > 0) {
      const Difference difference = Compare(comparison.missions[0], missions);
      of["against"] = comparison.policies[0];
      of["points_more"] = difference.points.mean;
      of["points_more_95"] =
          difference.low ? OrderedJson{*difference.low, *difference.high} : OrderedJson();
      of["more"] = difference.more;
      of["as_many"] = difference.as_many;
      of["fewer"] = difference.fewer;
    }
    json["policies"].push_back(std::move(of));
  }
  return json;
}

int CompareCommand(int argc, const char* const* argv) {
  Options options = CompareOptions();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  Comparison comparison;
  comparison.policies = arguments->All("policies");
  if (comparison.policies.size() < 2) {
    throw InputError("command line", "POLICY", fmt::format("{}", comparison.policies.size()),
                     "two or more policies, as horizon rollout-steps");
  }
  for (const std::string& policy : comparison.policies) {
    if (std::filesystem::is_directory(policy)) {
      throw InputError("command line", "POLICY", policy,
                       "a policy, as horizon; \"muster report RUN RUN\" compares runs");
    }
  }
  std::string title;
  const std::vector<NamedScenario> scenarios = ScenariosOf(*arguments, &title);
  for (const std::string& policy : comparison.policies) {
    for (const NamedScenario& named : scenarios) {
      scheduler::MakePolicy(policy)->CheckScenario(named.scenario);
    }
  }
  comparison.missions.assign(comparison.policies.size(),
                             std::vector<ComparedMission>(scenarios.size()));
  const StopSignals stop;
  ProgressPrinter progress(stderr, StyleFor(stderr, arguments->Has("quiet")));
  const TimeUs start_us = MonotonicUs();
  std::size_t ended = 0;
  std::string trouble;
  RunInProcesses(
      scenarios.size(), arguments->Get<int>("jobs"),
      [&](std::size_t i) { return Fly(scenarios[i], comparison.policies); },
      [&](std::size_t i, const std::string& text) {
        const OrderedJson rows = OrderedJson::parse(text);
        for (std::size_t p = 0; p < rows.size(); ++p) {
          comparison.missions[p][i] = {scenarios[i].name, rows[p]["done"], rows[p]["tasks"],
                                       NumberOf(rows[p]["response_s"]),
                                       NumberOf(rows[p]["decision_s"])};
        }
        ++ended;
        const TimeUs took_us = MonotonicUs() - start_us;
        if (progress.due(took_us)) {
          progress.Show(fmt::format("{} of {} missions", ended, scenarios.size()), took_us);
        }
      },
      [&](std::size_t i, const std::string& why) {
        trouble = fmt::format("{}: {}", scenarios[i].name, why);
      },
      [&] { return stop.count() > 0 || !trouble.empty(); });
  progress.Break();
  if (stop.count() > 0) return kExitInterrupted;
  if (!trouble.empty()) throw SystemError(trouble);
  if (arguments->Has("json")) {
    fmt::print("{}\n", ToJson(comparison).dump(2));
  } else {
    fmt::print("{}\n{}", title, ComparisonText(comparison));
  }
  return kExitOk;
}

}  // namespace muster::tools
