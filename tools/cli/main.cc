#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "tools/audit/audit_command.h"
#include "tools/bench/bench_command.h"
#include "tools/bound/bound_command.h"
#include "tools/cli/command.h"
#include "tools/explain/explain_command.h"
#include "tools/explain/redecide_command.h"
#include "tools/graph/graph_commands.h"
#include "tools/host/doctor_command.h"
#include "tools/launch/run_command.h"
#include "tools/live/live_command.h"
#include "tools/log/log_command.h"
#include "tools/replay/replay_command.h"
#include "tools/report/report_command.h"
#include "tools/scenario/import_command.h"
#include "tools/scenario/scenario_command.h"
#include "tools/simulate/simulate_command.h"
#include "tools/top/top_command.h"
#include "tools/trials/faults_command.h"

namespace muster::tools {
namespace {

struct Command {
  std::string_view name;
  std::string_view summary;
  CommandBody body;
};

/// One row a subcommand; its body lives in tools/<folder>/<name>_command.cc.
const std::vector<Command> kCommands = {
    {"doctor", "looks whether this host can run missions", DoctorCommand},
    {"audit", "checks a run's log against every rule of the mission", AuditCommand},
    {"bench", "compares policies, times decisions", BenchCommand},
    {"bound", "tells how many tasks any policy could do at most", BoundCommand},
    {"check-solution", "verifies another solver's answer on a decision", CheckSolutionCommand},
    {"explain", "says why a task or an agent was commanded as it was", ExplainCommand},
    {"export-graph", "writes a decision's conflict graph for other solvers", ExportGraphCommand},
    {"faults", "runs missions under fault plans and scores them, draws plans", FaultsCommand},
    {"import", "makes a scenario from a table of places (CSV, GeoJSON)", ImportCommand},
    {"live", "shows a mission in a browser while it goes on", LiveCommand},
    {"log", "sums up, repairs, cuts, exports logs", LogCommand},
    {"redecide", "makes a run's decisions again from its log", RedecideCommand},
    {"replay", "plays a log back over LCM", ReplayCommand},
    {"report", "makes one page of one or several runs", ReportCommand},
    {"run", "runs a mission as processes over LCM", RunCommand},
    {"scenario", "writes a random scenario, lists the presets", ScenarioCommand},
    {"simulate", "runs a mission in one process", SimulateCommand},
    {"top", "shows a mission in the terminal while it goes on", TopCommand},
};

void PrintUsage() {
  fmt::print(
      "Muster: disaster-response sensing missions with UAVs, vehicles and workers\n\n"
      "Usage: muster COMMAND [OPTION...]\n\nCommands:\n");
  for (const Command& command : kCommands) {
    fmt::print("  {:<14}  {}\n", command.name, command.summary);
  }
  fmt::print("\n'muster COMMAND --help' tells more of one command.\n");
}

int Main(int argc, char** argv) {
  const std::string_view name = argc > 1 ? argv[1] : "";
  if (name == "--help" || name == "-h" || name == "help") {
    PrintUsage();
    return kExitOk;
  }
  if (name == "--version") {
    fmt::print("muster {}\n", MUSTER_VERSION);
    return kExitOk;
  }
  for (const Command& command : kCommands) {
    if (command.name != name) continue;
    const std::string program = fmt::format("muster {}", name);
    std::vector<const char*> arguments(argv + 1, argv + argc);
    arguments[0] = program.c_str();
    return command.body(static_cast<int>(arguments.size()), arguments.data());
  }
  if (name.empty()) {
    PrintUsage();
    return kExitUsage;
  }
  throw InputError(fmt::format("no command '{}' (see muster --help)", name));
}

}  // namespace
}  // namespace muster::tools

int main(int argc, char** argv) {
  return muster::GuardedMain("muster", [&] { return muster::tools::Main(argc, argv); });
}
