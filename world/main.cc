#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <limits>
#include <sstream>

#include "base/check.h"
#include "base/program.h"
#include "model/agent.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "world/world_process.h"

namespace muster::world {
namespace {

double ReadRate(const std::string& text) {
  if (text == "max") return 0;
  char* end = nullptr;
  const double rate = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !(rate > 0)) {
    throw InputError("command line", "--rate", text,
                     "max, or mission seconds per wall second above 0");
  }
  return rate;
}

/// "uav:3:600000000:1200000000:f1"
Outage ReadOutage(const std::string& text) {
  Outage outage;
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ':');) parts.push_back(part);
  bool good = parts.size() == 5;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const std::string& part = parts[i + 1];
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    good = error == std::errc() && end == part.data() + part.size() && value >= 0;
    if (i == 0) {
      good = good && value <= std::numeric_limits<std::int32_t>::max();
      outage.agent = static_cast<std::int32_t>(value);
    }
    if (i == 1) outage.from_us = value;
    if (i == 2) outage.until_us = value;
  }
  bool known = false;
  for (const AgentKind kind : kAgentKinds) {
    if (!good || parts[0] != ToString(kind)) continue;
    outage.kind = kind;
    known = true;
  }
  if (!good || !known || outage.until_us <= outage.from_us || parts[4].empty()) {
    throw InputError("command line", "--outage", text, "CLASS:ID:FROM_US:UNTIL_US:FAULT");
  }
  outage.detail = parts[4];
  return outage;
}

int Main(int argc, char** argv) {
  cxxopts::Options options("muster-world", "The world of a mission: its clock and its referee");
  options.positional_help("SCENARIO");
  options.add_options()("scenario", "Scenario file", cxxopts::value<std::string>())(
      "rate", "Mission seconds per wall second, or max",
      cxxopts::value<std::string>()->default_value("max"))(
      "recorder", "A recorder takes part: wait for it, never run ahead of the log")(
      "on-loss", "When a process is lost: wait for it, or continue without it",
      cxxopts::value<std::string>()->default_value("wait"),
      "wait|continue")("lost-after", "Seconds of silence after which a process is lost",
                       cxxopts::value<double>()->default_value("5"))(
      "outage", "An agent fails in [FROM, UNTIL), by order of that fault",
      cxxopts::value<std::vector<std::string>>(), "CLASS:ID:FROM_US:UNTIL_US:FAULT");
  AddProcessOptions(&options, "world");
  options.parse_positional("scenario");
  const auto result = ParseOptions(&options, argc, argv);
  if (!result) return kExitOk;
  if (result->count("scenario") == 0) {
    throw InputError("command line", "SCENARIO", "nothing", "a scenario file");
  }
  ProcessFlags flags = ReadProcessFlags(*result, "world");
  WorldOptions world;
  world.rate = ReadRate((*result)["rate"].as<std::string>());
  world.recorded = result->count("recorder") > 0;
  const std::string on_loss = (*result)["on-loss"].as<std::string>();
  if (on_loss != "wait" && on_loss != "continue") {
    throw InputError("command line", "--on-loss", on_loss, "wait or continue");
  }
  world.goes_on = on_loss == "continue";
  const double lost_after_s = (*result)["lost-after"].as<double>();
  if (!(lost_after_s >= 0.5 && lost_after_s <= 3600)) {
    throw InputError("command line", "--lost-after", fmt::to_string(lost_after_s),
                     "seconds from 0.5 to 3600");
  }
  world.lost_after_us = ToUs(lost_after_s);
  if (result->count("outage") > 0) {
    for (const std::string& text : (*result)["outage"].as<std::vector<std::string>>()) {
      world.outages.push_back(ReadOutage(text));
    }
  }
  if (world.recorded && flags.window == 0) flags.window = 10;
  const Scenario scenario = LoadScenario((*result)["scenario"].as<std::string>());
  WorldProcess process(flags.identity, flags.window, ScenarioToJson(scenario), world);
  const auto bus = OpenBus(flags);
  return RunProcess(&process, bus.get(), flags.quiet);
}

}  // namespace
}  // namespace muster::world

int main(int argc, char** argv) {
  return muster::GuardedMain("muster-world", [&] { return muster::world::Main(argc, argv); });
}
