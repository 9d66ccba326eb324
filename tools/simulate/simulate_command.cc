#include "tools/simulate/simulate_command.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/say.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "simulation/start_process.h"
#include "tools/files/run_directory.h"
#include "tools/files/scenario_file.h"
#include "tools/host/stop_signals.h"
#include "tools/launch/fault_options.h"
#include "tools/record/report_json.h"
#include "tools/record/run_record.h"
#include "tools/record/summary.h"
#include "tools/scenario/mission_options.h"
#include "tools/simulate/virtual_mission.h"

namespace muster::tools {
namespace {

/// mission.lcm, and what a logger that is started again writes behind it.
class LogFiles {
 public:
  explicit LogFiles(const RunDirectory& directory) : directory_(directory) {}

  void Write(std::int64_t start, TimeUs received_us, const Packet& packet) {
    auto& writer = writers_[start];
    if (!writer) {
      const std::string name = start == 0 ? "mission.lcm" : fmt::format("mission.lcm.{}", start);
      writer = std::make_unique<EventLogWriter>(directory_.File(name));
    }
    writer->Write(received_us, packet);
  }
  void Flush() {
    for (auto& [start, writer] : writers_) writer->Flush();
  }

 private:
  const RunDirectory& directory_;
  std::map<std::int64_t, std::unique_ptr<EventLogWriter>> writers_;
};

/// At once, without a fault. There is no clock: a message is logged at its mission time.
MissionResult SimulateFast(const Scenario& scenario, const std::string& policy,
                           const std::vector<world::PlannedOrder>& orders, LogFiles* log) {
  MissionResult result;
  Simulate(
      TextOf(scenario), policy,
      [&](const Packet& packet) {
        result.record.Add(packet);
        if (log) log->Write(0, DecodeHeader(packet).value_or(header_t{}).sim_us, packet);
      },
      {}, orders);
  result.end = MissionEnd::kComplete;
  return result;
}

/// In virtual time.
MissionResult SimulateFaults(const Scenario& scenario, const std::string& policy,
                             const std::vector<world::PlannedOrder>& orders,
                             const FaultOptions& faults, int schedulers, int per_class,
                             std::uint64_t fault_seed, LogFiles* log) {
  const StopSignals stop;
  VirtualMission mission;
  mission.scenario = scenario;
  mission.policy = policy;
  mission.orders = orders;
  mission.schedulers = schedulers;
  mission.per_class = per_class;
  mission.faults = faults.faults;
  mission.goes_on = faults.goes_on();
  mission.lost_after_us = ToUs(faults.lost_after_s);
  mission.restarts.most = faults.restarts;
  mission.drop = faults.drop;
  mission.fault_seed = fault_seed;
  mission.say = [](const std::string& line) { Say("muster: {}\n", line); };
  mission.stops_asked = [&] { return stop.count(); };
  if (log) {
    mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t start) {
      log->Write(start, event.received_us, *event.packet);
    };
  }
  return RunVirtualMission(mission);
}

}  // namespace

int SimulateCommand(int argc, const char* const* argv) {
  Options parser(
      "muster simulate",
      "Runs a whole mission in one process, without LCM: the same decisions and outcomes "
      "as muster run. With faults, in virtual time. Writes files only with --out.");
  AddMissionOptions(&parser);
  parser.Json();
  parser.Flag("log", "Record the messages too, as mission.lcm in the run directory");
  AddFaultOptions(&parser);
  parser
      .Add("fault-seed", "N",
           "Seed of the loss and the delays of packets (default: the scenario's)")
      .Seed();
  parser
      .Add("schedulers", "N",
           "How many schedulers decide, in virtual time (docs/reference/schedulers.md)")
      .Integer(1, world::kMostSchedulers)
      .Default(1);
  parser.Add("processes", "N", "Processes of each agent class, in virtual time")
      .Integer(1, simulation::kMostPerClass)
      .Default(1);
  const auto arguments = parser.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const MissionOptions options = ReadMissionOptions(*arguments);
  FaultOptions faults = ReadFaultOptions(*arguments);
  if (arguments->Has("log") && options.out.empty()) {
    throw InputError("command line", "--log", "no --out", "--out DIR, where the log goes");
  }
  std::vector<world::PlannedOrder> orders;
  const Scenario scenario = ResolveScenario(options, &orders);
  std::vector<std::string> names = {process_name::kRecorder};
  const int schedulers = arguments->Get<int>("schedulers");
  const int per_class = arguments->Get<int>("processes");
  for (const AgentKind kind : kAgentKinds) {
    if (per_class == 1 || per_class <= static_cast<int>(scenario.agents(kind).size())) continue;
    throw InputError("command line", "--processes", fmt::to_string(per_class),
                     fmt::format("at most {}, the scenario's {}s", scenario.agents(kind).size(),
                                 ToString(kind)));
  }
  for (const std::string& name : simulation::ProcessNames(schedulers, per_class)) {
    names.push_back(name);
  }
  CheckFaultPlan(&faults.faults, names, scenario, faults.goes_on());
  std::optional<RunDirectory> directory;
  if (!options.out.empty()) directory = RunDirectory::Take(options.out);
  std::optional<LogFiles> log;
  if (arguments->Has("log")) log.emplace(*directory);

  LogFiles* const to = log ? &*log : nullptr;
  std::optional<std::uint64_t> fault_seed;
  arguments->Read("fault-seed", &fault_seed);
  const bool is_virtual = fault_seed || faults.drop > 0 || !faults.faults.empty() ||
                          faults.goes_on() || schedulers > 1 || per_class > 1;
  const MissionResult result =
      is_virtual ? SimulateFaults(scenario, options.policy, orders, faults, schedulers, per_class,
                                  fault_seed.value_or(scenario.seed), to)
                 : SimulateFast(scenario, options.policy, orders, to);
  if (log) log->Flush();
  PrintProblems(result);
  if (directory) {
    WriteScenarioFile(scenario, directory->File("scenario.json"));
    directory->Write("report.json", Report(result.record).dump(2) + "\n");
  }
  fmt::print(
      "{}", arguments->Has("json") ? Report(result.record).dump(2) + "\n" : Summary(result.record));
  return is_virtual ? ExitCodeOf(result) : kExitOk;
}

}  // namespace muster::tools
