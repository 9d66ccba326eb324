#include <vector>

#include "base/program.h"
#include "tools/audit/audit_command.h"
#include "tools/bench/bench_command.h"
#include "tools/bench/compare_command.h"
#include "tools/bound/bound_command.h"
#include "tools/drive/drive_command.h"
#include "tools/explain/explain_command.h"
#include "tools/explain/redecide_command.h"
#include "tools/graph/graph_commands.h"
#include "tools/host/doctor_command.h"
#include "tools/launch/resume_command.h"
#include "tools/launch/run_command.h"
#include "tools/live/live_command.h"
#include "tools/log/log_command.h"
#include "tools/orders/feed_command.h"
#include "tools/orders/order_commands.h"
#include "tools/orders/person_command.h"
#include "tools/orders/what_if.h"
#include "tools/replay/replay_command.h"
#include "tools/report/report_command.h"
#include "tools/scenario/import_command.h"
#include "tools/scenario/policies_command.h"
#include "tools/scenario/scenario_command.h"
#include "tools/simulate/simulate_command.h"
#include "tools/top/top_command.h"
#include "tools/train/train_command.h"
#include "tools/trials/faults_command.h"

namespace muster::tools {
namespace {

/// One row a subcommand; its body lives in tools/<folder>/<name>_command.cc.
const std::vector<Command> kCommands = {
    {"doctor", "looks whether this host can run missions", DoctorCommand},
    {"agent", "has an agent join or leave a running mission", AgentCommand},
    {"audit", "checks a run's log against every rule of the mission", AuditCommand},
    {"bench", "compares policies, times decisions", BenchCommand},
    {"bound", "tells how many tasks any policy could do at most", BoundCommand},
    {"check-solution", "verifies another solver's answer on a decision", CheckSolutionCommand},
    {"compare", "simulates the same missions with several policies", CompareCommand},
    {"decide", "has a running mission decide now, not at the next interval", DecideCommand},
    {"direct", "decides in the policy's place: pins, forbids, sends", DirectCommand},
    {"drive", "tries out a driver, a program that takes an agent's part", DriveCommand},
    {"explain", "says why a task or an agent was commanded as it was", ExplainCommand},
    {"export-graph", "writes a decision's conflict graph for other solvers", ExportGraphCommand},
    {"faults", "runs missions under fault plans and scores them, draws plans", FaultsCommand},
    {"feed", "gives a running mission tasks and orders as they come", FeedCommand},
    {"import", "makes a scenario from a table of places (CSV, GeoJSON)", ImportCommand},
    {"live", "shows a mission in a browser while it goes on", LiveCommand},
    {"log", "sums up, repairs, cuts, exports logs", LogCommand},
    {"person", "says who may order in a mission, by role", PersonCommand},
    {"policies", "says which policy to take for what", PoliciesCommand},
    {"redecide", "makes a run's decisions again from its log", RedecideCommand},
    {"replay", "plays a log back over LCM", ReplayCommand},
    {"report", "makes one page of one or several runs", ReportCommand},
    {"resume", "goes on with a mission whose launcher has gone", ResumeCommand},
    {"road", "closes or opens roads of a running mission", RoadCommand},
    {"zone", "adds or lifts a zone that UAVs keep out of in a running mission", ZoneCommand},
    {"run", "runs a mission as processes over LCM", RunCommand},
    {"scenario", "writes a random scenario, lists the presets", ScenarioCommand},
    {"simulate", "runs a mission in one process", SimulateCommand},
    {"task", "adds, changes, cancels or holds a task of a running mission", TaskCommand},
    {"top", "shows a mission in the terminal while it goes on", TopCommand},
    {"what-if", "says what a directive would change", WhatIfCommand},
    {"train", "trains a learned policy", TrainCommand},
};

}  // namespace
}  // namespace muster::tools

int main(int argc, char** argv) {
  return muster::GuardedMain("muster", [&] {
    return muster::RunCommandOf(
        "muster", "Muster: disaster-response sensing missions with UAVs, vehicles and workers",
        muster::tools::kCommands, argc, argv);
  });
}
