#include "tools/simulate/simulate_command.h"

#include <fmt/format.h>

#include <optional>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/files/run_directory.h"
#include "tools/record/report_json.h"
#include "tools/record/run_record.h"
#include "tools/record/summary.h"
#include "tools/scenario/mission_options.h"

namespace muster::tools {

int SimulateCommand(int argc, const char* const* argv) {
  Options parser(
      "muster simulate",
      "Runs a whole mission in one process, without LCM: the same decisions and outcomes "
      "as muster run. Writes files only with --out.");
  AddMissionOptions(&parser);
  parser.Flag("log", "Record the messages too, as mission.lcm in the run directory");
  const auto arguments = parser.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const MissionOptions options = ReadMissionOptions(*arguments);
  if (arguments->Has("log") && options.out.empty()) {
    throw InputError("command line", "--log", "no --out", "--out DIR, where the log goes");
  }
  const std::string json = ScenarioToJson(ResolveScenario(options));
  std::optional<RunDirectory> directory;
  if (!options.out.empty()) directory = RunDirectory::Take(options.out);

  std::optional<EventLogWriter> log;
  if (arguments->Has("log")) log.emplace(directory->File("mission.lcm"));

  RunRecord record;
  Simulate(json, options.policy, [&](const Packet& packet) {
    record.Add(packet);
    // There is no wall clock: a message is logged at its mission time.
    if (log) log->Write(DecodeHeader(packet).value_or(header_t{}).sim_us, packet);
  });
  if (log) log->Flush();
  if (directory) {
    directory->Write("scenario.json", json);
    directory->Write("report.json", Report(record).dump(2) + "\n");
  }
  fmt::print("{}", Summary(record));
  return kExitOk;
}

}  // namespace muster::tools
