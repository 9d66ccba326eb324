#include "tools/simulate/simulate_command.h"

#include <fmt/format.h>

#include <optional>

#include "lcmtypes/protocol/program.h"
#include "tools/launch/mission_options.h"
#include "tools/launch/run_directory.h"
#include "tools/report/report_json.h"
#include "tools/report/run_record.h"
#include "tools/report/summary.h"
#include "tools/simulate/simulator.h"
#include "world/model/scenario_json.h"

namespace muster::tools {

int SimulateCommand(int argc, const char* const* argv) {
  cxxopts::Options parser(
      "muster simulate",
      "Runs a whole mission in one process, without LCM: the same decisions and "
      "outcomes as muster run. Writes files only with --out.");
  AddMissionOptions(&parser);
  const auto result = ParseOptions(&parser, argc, argv);
  if (!result) return kExitOk;
  const MissionOptions options = ReadMissionOptions(*result);
  const std::string json = ScenarioToJson(ResolveScenario(options));
  std::optional<RunDirectory> directory;
  if (!options.out.empty()) directory = RunDirectory::Take(options.out);

  RunRecord record;
  Simulate(json, options.policy, [&](const Packet& packet) { record.Add(packet); });
  if (directory) {
    directory->Write("scenario.json", json);
    directory->Write("report.json", Report(record).dump(2) + "\n");
  }
  fmt::print("{}", Summary(record));
  return kExitOk;
}

}  // namespace muster::tools
