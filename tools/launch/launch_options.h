#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/bus/member_keys.h"
#include "lcmtypes/bus/seal.h"
#include "model/scenario.h"
#include "tools/launch/fault_options.h"
#include "tools/launch/hosts.h"
#include "tools/launch/supervisor.h"
#include "tools/scenario/mission_options.h"

namespace muster::tools {

/// A program that takes an agent's part.
struct DriverPlan {
  AgentKind kind = AgentKind::kUav;
  std::int32_t id = -1;
  std::string command;
};

/// What `muster run` was asked for.
struct LaunchOptions : MissionOptions, FaultOptions {
  std::string rate;                   ///< as muster-world takes it
  std::optional<double> deadline_ms;  ///< of each decision
  std::map<AgentKind, int> processes;
  int schedulers = 1;  ///< processes; 0: every agent process decides (Deciders)
  /// Your own in place of muster-ROLE, absolute; by role (world, uav, worker, vehicle, scheduler)
  /// or by name, such as scheduler-2.
  std::map<std::string, std::string> programs;
  std::vector<DriverPlan> drivers;
  Logger logger = Logger::kMuster;
  std::string second_log;        ///< the folder of a second recorder's; "": there is none
  bool recorded = true;          ///< false: no log is written or waited for
  bool takes_orders = false;     ///< while it goes on
  bool control = false;          ///< the live page may give them
  std::string persons_file;      ///< who may; "": everybody who reaches the mission
  std::optional<int> live_port;  ///< show it in browsers of this host; 0: any free port
  std::string tiles;             ///< the file of its base map; "": it has none
  std::string lcm_url;           ///< "": a network of the mission's own, or a free port
  std::string hosts_file;
  HostList hosts;  ///< empty: all processes run here
  bool sealed = false;
  bool sealed_per_process = false;
  std::string key_file;  ///< "": a fresh key for this mission alone
};

/// Reads the command line. No value: --help or --version was answered. Throws InputError.
std::optional<LaunchOptions> ParseLaunchOptions(int argc, const char* const* argv);

/// The driven agents are measured. Throws InputError where the scenario has no such agent.
void MarkDriven(const std::vector<DriverPlan>& drivers, Scenario* scenario);

/// How many messages a process may have sent that are not in the log yet (--window), where
/// lcm-logger writes it. lcm-logger queues 30 messages, so the windows of all processes that send
/// at once add up to less than 30 where that is possible.
inline constexpr int kLoggerQueue = 30;
inline constexpr int kProcessWindow = 3;
/// The window of each agent process and of the scheduler; 0: nothing is recorded.
int WindowOf(const LaunchOptions& options);

/// How many decide: the schedulers, or where there are none the agent processes, without programs
/// of the user's.
int Deciders(const LaunchOptions& options);

/// One process of a mission: its program (absolute, or in the folder of `muster`) and arguments. A
/// process with `--key -` among them gets the key on its stdin.
struct ProcessPlan {
  std::string name;
  std::string decides_as = {};  ///< the scheduler that is part of it; "": none is
  std::string program;
  std::vector<std::string> arguments;
  std::optional<AgentBlock> agents = {};  ///< that it reports
};

/// What a mission's processes have in common.
struct MissionIdentity {
  std::string scenario_file;  ///< the resolved one
  std::string lcm_url;
  std::int64_t run_id = 0;
  std::optional<SealKey> key = {};  ///< none: not sealed
  std::string orders_file = {};     ///< "": none are given with the mission
};

/// The processes to start, in that order. An agent class in k > 1 processes is named uav-1 ...
/// uav-k and dealt out in blocks of ids. Throws InputError when a class has fewer agents than
/// processes.
std::vector<ProcessPlan> PlanProcesses(const LaunchOptions& options, const Scenario& scenario,
                                       const MissionIdentity& mission);

}  // namespace muster::tools
