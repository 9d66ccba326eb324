#include "tools/scenario/mission_options.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "base/check.h"
#include "model/scenario_json.h"
#include "scheduler/policies/registry.h"

namespace muster::tools {
namespace {

constexpr std::string_view kCommandLine = "command line";

TimeUs MinutesToUs(double minutes, const char* flag) {
  if (!std::isfinite(minutes) || minutes <= 0 || minutes > 1e6) {
    throw InputError(kCommandLine, flag, fmt::to_string(minutes), "minutes above 0");
  }
  return ToUs(minutes * 60);
}

std::string PolicyHelp() {
  std::string help = "How to decide:";
  for (const scheduler::PolicyInfo& policy : scheduler::Policies()) {
    help += fmt::format(" {}", policy.name);
  }
  return help;
}

}  // namespace

void AddRuleOptions(cxxopts::Options* parser) {
  parser->positional_help("SCENARIO");
  parser->add_options()("scenario", "Scenario file", cxxopts::value<std::string>());
  parser->add_options()("interval", "Minutes between decisions (default: the scenario's)",
                        cxxopts::value<double>(), "MIN");
  parser->add_options()("limit", "Minutes of mission (default: the scenario's)",
                        cxxopts::value<double>(), "MIN");
  parser->add_options()("availability",
                        "strict: no action that may end after a participant's time or the limit; "
                        "overrun: it may (default: the scenario's)",
                        cxxopts::value<std::string>(), "MODE");
  parser->parse_positional("scenario");
}

MissionOptions ReadRuleOptions(const cxxopts::ParseResult& result) {
  MissionOptions options;
  if (result.count("scenario") == 0) {
    throw InputError(kCommandLine, "SCENARIO", "nothing", "a scenario file");
  }
  options.scenario_file = result["scenario"].as<std::string>();
  if (result.count("interval") > 0) options.interval_min = result["interval"].as<double>();
  if (result.count("limit") > 0) options.limit_min = result["limit"].as<double>();
  if (result.count("availability") > 0) {
    const std::string mode = result["availability"].as<std::string>();
    if (mode != "strict" && mode != "overrun") {
      throw InputError(kCommandLine, "--availability", mode, "strict or overrun");
    }
    options.availability = mode == "strict" ? Availability::kStrict : Availability::kOverrun;
  }
  return options;
}

void AddMissionOptions(cxxopts::Options* parser) {
  AddRuleOptions(parser);
  parser->add_options()(
      "policy", PolicyHelp(),
      cxxopts::value<std::string>()->default_value(std::string(scheduler::kDefaultPolicy)), "NAME");
  parser->add_options()("seed", "Seed of the mission's chances (default: the scenario's)",
                        cxxopts::value<std::uint64_t>(), "N");
  parser->add_options()("out", "Run directory, new or empty", cxxopts::value<std::string>(), "DIR");
  parser->add_options()("q,quiet", "No progress on stderr, only errors");
}

MissionOptions ReadMissionOptions(const cxxopts::ParseResult& result, bool own_policy) {
  MissionOptions options = ReadRuleOptions(result);
  options.policy = result["policy"].as<std::string>();
  // An unknown name is an error before the first file.
  if (!own_policy) scheduler::MakePolicy(options.policy);
  if (result.count("seed") > 0) options.seed = result["seed"].as<std::uint64_t>();
  if (result.count("out") > 0) {
    options.out = result["out"].as<std::string>();
    if (options.out.empty()) throw InputError(kCommandLine, "--out", "nothing", "a folder");
  }
  options.quiet = result.count("quiet") > 0;
  return options;
}

Scenario ResolveScenario(const MissionOptions& options) {
  Scenario scenario = LoadScenario(options.scenario_file);
  if (options.interval_min) {
    scenario.rules.interval_us = MinutesToUs(*options.interval_min, "--interval");
  }
  if (options.limit_min) scenario.rules.limit_us = MinutesToUs(*options.limit_min, "--limit");
  if (options.seed) scenario.seed = *options.seed;
  if (options.availability) scenario.rules.availability = *options.availability;
  ValidateScenario(scenario, options.scenario_file);
  return scenario;
}

}  // namespace muster::tools
