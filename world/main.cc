#include <fmt/format.h>

#include <cstdlib>

#include "lcmtypes/protocol/program.h"
#include "lcmtypes/protocol/run_process.h"
#include "world/model/check.h"
#include "world/model/scenario_json.h"
#include "world/truth/world_process.h"

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

int Main(int argc, char** argv) {
  cxxopts::Options options("muster-world", "The world of a mission: its clock and its referee");
  options.positional_help("SCENARIO");
  options.add_options()("scenario", "Scenario file", cxxopts::value<std::string>())(
      "rate", "Mission seconds per wall second, or max",
      cxxopts::value<std::string>()->default_value("max"))(
      "recorder", "A recorder takes part: wait for it, never run ahead of the log");
  AddProcessOptions(&options, "world");
  options.parse_positional("scenario");
  const auto result = ParseOptions(&options, argc, argv);
  if (!result) return kExitOk;
  if (result->count("scenario") == 0) {
    throw InputError("command line", "SCENARIO", "nothing", "a scenario file");
  }
  ProcessFlags flags = ReadProcessFlags(*result);
  WorldOptions world;
  world.rate = ReadRate((*result)["rate"].as<std::string>());
  world.recorded = result->count("recorder") > 0;
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
