#include "tools/launch/launch_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>
#include <string_view>

#include "agents/driver/driver_program.h"
#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text.h"
#include "lcmtypes/bus/multicast.h"
#include "model/agent.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "protocol/sender.h"
#include "scheduler/policies/registry.h"
#include "tools/live/live_server.h"
#include "tools/report/page.h"
#include "world/world_process.h"

namespace muster::tools {
namespace {

constexpr std::string_view kCommandLine = "command line";
constexpr int kMostProcesses = 64;
constexpr int kMostThink_s = 3600;
constexpr const char* kSealed = "mission";
constexpr const char* kSealedPerProcess = "per-process";

void ReadProcesses(const std::vector<std::string>& entries, LaunchOptions* options) {
  for (const AgentKind kind : kAgentKinds) options->processes[kind] = 1;
  // Agents that agree among themselves need no process that does it for them.
  if (scheduler::BaseName(options->policy) == scheduler::kNeighbours) options->schedulers = 0;
  for (const std::string& entry : entries) {
    const std::vector<std::string> parts = Split(entry, '=');
    const bool decides = parts[0] == process_name::kScheduler;
    const auto kind = FromString<AgentKind>(parts[0]);
    const auto count = decides ? ToInteger(parts.back(), 0, world::kMostSchedulers)
                               : ToInteger(parts.back(), 0, kMostProcesses);
    if (parts.size() != 2 || !count || (!decides && !kind)) {
      throw InputError(
          kCommandLine, "--processes", entry,
          fmt::format("uav=N, worker=N or vehicle=N with N from 0 to {}, scheduler=N from 0 to {}",
                      kMostProcesses, world::kMostSchedulers));
    }
    (decides ? options->schedulers : options->processes[*kind]) = static_cast<int>(*count);
  }
}

std::map<std::string, std::string> ReadPrograms(const std::vector<std::string>& entries) {
  static constexpr std::string_view kRoles[] = {
      process_name::kWorld, ToString(AgentKind::kUav), ToString(AgentKind::kWorker),
      ToString(AgentKind::kVehicle), process_name::kScheduler};
  namespace fs = std::filesystem;
  std::map<std::string, std::string> programs;
  for (const std::string& entry : entries) {
    const std::size_t equals = std::min(entry.find('='), entry.size());
    const std::string role = entry.substr(0, equals);
    const std::string file = entry.substr(std::min(equals + 1, entry.size()));
    const bool is_known = process_name::IsOneOfSchedulers(role) ||
                          std::find(std::begin(kRoles), std::end(kRoles), role) != std::end(kRoles);
    if (!is_known || !fs::is_regular_file(file) || access(file.c_str(), X_OK) != 0) {
      throw InputError(kCommandLine, "--program", entry,
                       "ROLE=FILE: world, uav, worker, vehicle or scheduler, and a program");
    }
    programs[role] = fs::absolute(file).string();
  }
  return programs;
}

void AddLaunchOptions(Options* options) {
  AddMissionOptions(options);
  scheduler::AddDeadlineOption(options);
  options
      ->Add(
          "think", "S",
          "rollout, rollout-steps: search for S seconds at each decision, while the mission waits "
          "(default: the policy's own search, so that decisions can be repeated)")
      .Number(Above0(kMostThink_s));
  AddRateOption(options);
  options
      ->Add("processes", "CLASS=N,...",
            "Processes per agent class, e.g. uav=2,vehicle=3; 0: none, you start them. "
            "scheduler=3: three decide, so any one of them may die "
            "(docs/reference/schedulers.md). scheduler=0: the agents' processes decide "
            "(docs/guide/without-a-centre.md)")
      .List();
  options
      ->Add("program", "ROLE=FILE,...",
            "Your own program in place of muster-ROLE, with the same options, e.g. "
            "worker=./my-worker (docs/guide/installing.md)")
      .List();
  options
      ->Add(
          "driver", "AGENT=COMMAND",
          "A program that takes an agent's part (docs/guide/drivers.md), e.g. uav:3='./my-driver'")
      .Repeated();
  options
      ->Add("logger", "lcm|muster",
            "Who writes the log: stock lcm-logger, or muster-recorder, which takes less of the "
            "processors (docs/guide/running.md)")
      .OneOf({"lcm", "muster"})
      .Default("muster");
  options->Add("second-log", "FOLDER",
               "A second recorder writes the whole log there too: on another disk, or on the host "
               "that has recorder-2 in its list (--hosts; docs/guide/resuming.md)");
  options->Flag("take-orders",
                "Take orders while it goes on (muster task, muster agent, muster feed; "
                "docs/guide/orders.md)");
  options
      ->Add("room", "WHAT=N,...",
            "How many tasks and agents orders may add, e.g. task=500,uav=2 (default with "
            "--take-orders: task=1000,uav=20,worker=20,vehicle=20)")
      .List();
  AddFaultOptions(options);
  options->Add("l,lcm-url", "URL", "LCM URL (default: a network of the mission's own)");
  options->Add("hosts", "FILE", "Which process runs on which host (docs/guide/hosts.md)");
  options
      ->Add("seal", "HOW",
            "Accept only messages that were sealed with the mission's key (docs/guide/seal.md). "
            "HOW mission: one key for all processes; per-process: one for each, which cannot speak "
            "for another. The key is new, and kept in seal.key of the run directory. Default with "
            "--hosts: mission")
      .OneOf({kSealed, kSealedPerProcess})
      .Implied(kSealed);
  options->Add("key", "FILE", "Seal with the key in FILE, which only its owner may read");
  options->Flag("no-seal", "With --hosts: accept messages without a seal");
  options
      ->Add("live", "PORT",
            "Show the mission in browsers of this host. The page stays after the mission's end "
            "until Ctrl-C. PORT 0: any free port")
      .Integer(0, 65535)
      .Implied(fmt::to_string(kDefaultLivePort));
  options->Add(
      "tiles", "FILE",
      "With --live: base map, an MBTiles or PMTiles file, or none (default: the file beside "
      "the scenario that has its name)");
  options->Add("persons", "FILE",
               "Take orders only of the persons in FILE, by their roles (muster person; "
               "docs/guide/persons.md). Includes --take-orders");
  options->Flag("control",
                "With --live: everyone who opens the printed address may also give orders there");
}

/// Several schedulers must decide alike.
void CheckSchedulers(const LaunchOptions& options) {
  for (const auto& [name, program] : options.programs) {
    if (!process_name::IsOneOfSchedulers(name)) continue;
    if (options.schedulers == 0 || !world::SchedulerNames(options.schedulers).contains(name)) {
      throw InputError(kCommandLine, "--program", name,
                       "a process of the mission (--processes scheduler=N)");
    }
  }
  if (options.schedulers == 1) return;
  const bool by_policy = scheduler::BaseName(options.policy) == scheduler::kNeighbours;
  const std::string several = fmt::format(
      "scheduler={}{}", options.schedulers,
      options.schedulers == 0 && by_policy ? fmt::format(" (--policy {})", options.policy) : "");
  if (options.schedulers == 0 && options.programs.contains(process_name::kScheduler)) {
    throw InputError(kCommandLine, "--processes", several, "no --program scheduler=FILE with it");
  }
  if (const int deciders = Deciders(options); deciders < 1 || deciders > world::kMostSchedulers) {
    throw InputError(
        kCommandLine, "--processes", several,
        fmt::format("1 to {} agent processes of Muster's own with it, which decide; there "
                    "are {}",
                    world::kMostSchedulers, deciders));
  }
  if (options.deadline_ms) {
    throw InputError(kCommandLine, "--processes", several,
                     "no --deadline with it: what is decided by the clock differs from one "
                     "scheduler to the other");
  }
  if (options.policy.starts_with("external:")) {
    throw InputError(kCommandLine, "--processes", several,
                     "no external policy with it: its answer may come too late at one scheduler "
                     "and in time at the other");
  }
}

/// --think is more search than there is time for, ended by the clock.
void ReadDeadline(const Arguments& arguments, bool own_policy, LaunchOptions* options) {
  arguments.Read("deadline", &options->deadline_ms);
  if (!arguments.Has("think")) return;
  const auto seconds = arguments.Get<double>("think");
  const auto refuse = [&](std::string_view expected) {
    throw InputError(kCommandLine, "--think", fmt::format("{} s", seconds), expected);
  };
  if (options->deadline_ms) refuse("no --deadline with it, which says the same in milliseconds");
  if (own_policy || !scheduler::MakePolicy(options->policy)->Set("effort", 1000)) {
    refuse(fmt::format("--policy rollout or rollout-steps with it, not {}", options->policy));
  }
  if (options->policy.find(":effort=") != std::string::npos) {
    refuse("no --effort with it, which is a fixed amount of search");
  }
  options->deadline_ms = 1000 * seconds;
  options->policy += ":effort=1000";
}

std::vector<DriverPlan> ReadDrivers(const std::vector<std::string>& entries) {
  std::vector<DriverPlan> drivers;
  for (const std::string& entry : entries) {
    const std::size_t sign = std::min(entry.find('='), entry.size());
    const std::vector<std::string> agent = Split(entry.substr(0, sign), ':');
    const auto kind = FromString<AgentKind>(agent.front());
    const auto id = ToInteger(agent.back(), 0, std::numeric_limits<std::int32_t>::max());
    if (sign == entry.size() || agent.size() != 2 || !kind || !id) {
      throw InputError(kCommandLine, "--driver", entry,
                       "AGENT=COMMAND, e.g. uav:3='./my-driver --fast'");
    }
    const DriverPlan driver{*kind, static_cast<std::int32_t>(*id), entry.substr(sign + 1)};
    agents::DriverCommand(driver.command);  // throws where there is no such program
    const auto has_one = [&](const DriverPlan& other) {
      return other.kind == driver.kind && other.id == driver.id;
    };
    if (std::any_of(drivers.begin(), drivers.end(), has_one)) {
      throw InputError(kCommandLine, "--driver", entry, "one driver for each agent");
    }
    drivers.push_back(driver);
  }
  return drivers;
}

/// "--seal HOW" as "--seal=HOW": alone it is an option whose value may be left out.
std::vector<std::string> JoinSeal(std::vector<std::string> words) {
  const auto seal = std::find(words.begin(), words.end(), "--seal");
  if (seal == words.end() || seal + 1 == words.end()) return words;
  if (*(seal + 1) != kSealed && *(seal + 1) != kSealedPerProcess) return words;
  *seal += "=" + *(seal + 1);
  words.erase(seal + 1);
  return words;
}

void ReadSeal(const Arguments& arguments, LaunchOptions* options) {
  options->key_file = arguments.Has("key") ? arguments.Get("key") : "";
  options->sealed_per_process = arguments.Has("seal") && arguments.Get("seal") == kSealedPerProcess;
  options->sealed = arguments.Has("seal") || arguments.Has("key") || arguments.Has("hosts");
  if (!arguments.Has("no-seal")) return;
  if (arguments.Has("seal") || arguments.Has("key")) {
    throw InputError(kCommandLine, "--no-seal", arguments.Has("key") ? "--key" : "--seal",
                     "one of the two");
  }
  options->sealed = false;
}

Room ReadRoom(const std::vector<std::string>& entries) {
  Room room = {1000, {20, 20, 20}};
  for (const std::string& entry : entries) {
    const std::vector<std::string> parts = Split(entry, '=');
    const auto count = ToInteger(parts.back(), 0, kMostRoom);
    const auto kind = FromString<AgentKind>(parts[0]);
    if (!count || parts.size() != 2 || (!kind && parts[0] != "task")) {
      throw InputError(
          kCommandLine, "--room", entry,
          fmt::format("task=N, uav=N, worker=N or vehicle=N with N from 0 to {}", kMostRoom));
    }
    (kind ? room.agents[*kind] : room.tasks) = static_cast<std::size_t>(*count);
  }
  return room;
}

/// Those of the agents first to last.
void AddDrivers(const LaunchOptions& options, AgentKind kind, int first, int last,
                std::vector<std::string>* arguments) {
  bool any = false;
  for (const DriverPlan& driver : options.drivers) {
    if (driver.kind != kind || driver.id < first || driver.id > last) continue;
    arguments->insert(arguments->end(),
                      {"--driver", fmt::format("{}={}", driver.id, driver.command)});
    any = true;
  }
  if (!any) return;
  arguments->insert(arguments->end(),
                    {"--rate", options.rate, "--lost-after", fmt::to_string(options.lost_after_s)});
}

/// Where the user starts the processes of a class (--processes CLASS=0), refuses drivers of that
/// class and a network of the mission's own.
void CheckOwnProcesses(const LaunchOptions& options) {
  for (const DriverPlan& driver : options.drivers) {
    if (options.processes.at(driver.kind) > 0) continue;
    throw InputError(
        kCommandLine, "--driver", fmt::format("{}:{}", ToString(driver.kind), driver.id),
        fmt::format("no --processes {}=0 with it: a process that you start takes its own --driver",
                    ToString(driver.kind)));
  }
  for (const auto& [kind, count] : options.processes) {
    if (count == 0 && options.lcm_url.empty()) {
      throw InputError(kCommandLine, "--processes", fmt::format("{}=0", ToString(kind)),
                       "--lcm-url with it: a process of yours cannot reach a network of the "
                       "mission's own");
    }
  }
}

}  // namespace

int Deciders(const LaunchOptions& options) {
  if (options.schedulers > 0) return options.schedulers;
  int processes = 0;
  for (const auto& [kind, count] : options.processes) {
    if (!options.programs.contains(std::string(ToString(kind)))) processes += count;
  }
  return processes;
}

int WindowOf(const LaunchOptions& options) {
  if (!options.recorded) return 0;
  if (options.logger == Logger::kMuster) return kMemberWindow;
  // lcm-logger's queue is one for all who report at once: the more there are, the less each has.
  int processes = options.schedulers == 0 ? Deciders(options) : 0;  // each sends as two
  for (const auto& [kind, count] : options.processes) processes += count;
  return std::clamp(kLoggerQueue / std::max(processes, 1), 1, kProcessWindow);
}

std::optional<LaunchOptions> ParseLaunchOptions(int argc, const char* const* argv) {
  Options parser("muster run",
                 "Runs a whole mission: world, agents and scheduler as processes of their own over "
                 "LCM, recorded in lcm-logger's format.");
  AddLaunchOptions(&parser);
  const std::vector<std::string> words = JoinSeal({argv, argv + argc});
  std::vector<const char*> joined;
  for (const std::string& word : words) joined.push_back(word.c_str());
  const auto arguments = parser.Parse(static_cast<int>(joined.size()), joined.data());
  if (!arguments) return std::nullopt;

  LaunchOptions options;
  options.programs = ReadPrograms(arguments->All("program"));
  static_cast<FaultOptions&>(options) = ReadFaultOptions(*arguments);
  const bool own_policy = options.programs.contains(process_name::kScheduler);
  static_cast<MissionOptions&>(options) = ReadMissionOptions(*arguments, own_policy);
  if (own_policy && !arguments->Has("policy")) {
    throw InputError(kCommandLine, "--program", "scheduler without --policy",
                     "--policy with it: the name of a policy that your scheduler has");
  }
  options.rate = arguments->Get("rate");
  options.drivers = ReadDrivers(arguments->All("driver"));
  options.logger = arguments->Get("logger") == "lcm" ? Logger::kLcm : Logger::kMuster;
  arguments->Read("second-log", &options.second_log);
  if (!options.second_log.empty() && options.logger == Logger::kLcm) {
    throw InputError(kCommandLine, "--second-log", "--logger lcm",
                     "--logger muster with it: stock lcm-logger knows of no second one");
  }
  ReadDeadline(*arguments, own_policy, &options);
  // Throws where it does not fit.
  if (!own_policy) scheduler::MakePolicy(options.policy, options.deadline_ms);
  ReadProcesses(arguments->All("processes"), &options);
  CheckSchedulers(options);
  if (arguments->Has("lcm-url")) {
    options.lcm_url = arguments->Get("lcm-url");
    ParseMulticastUrl(options.lcm_url);
  }
  if (arguments->Has("hosts")) {
    options.hosts_file = arguments->Get("hosts");
    options.hosts = LoadHosts(options.hosts_file);
    if (!options.lcm_url.empty()) {
      throw InputError(kCommandLine, "--lcm-url", options.lcm_url,
                       "not with --hosts, whose file has it as lcm_url");
    }
    options.lcm_url = options.hosts.lcm_url;
  }
  ReadSeal(*arguments, &options);
  options.control = arguments->Has("control");
  if (options.control && !arguments->Has("live")) {
    throw InputError(kCommandLine, "--control", "no --live",
                     "--live with it: --control gives rights on its page");
  }
  arguments->Read("persons", &options.persons_file);
  options.takes_orders =
      arguments->Has("take-orders") || options.control || !options.persons_file.empty();
  if (arguments->Has("room") && !options.takes_orders) {
    throw InputError(kCommandLine, "--room", "no --take-orders", "--take-orders with it");
  }
  if (options.takes_orders) options.room = ReadRoom(arguments->All("room"));
  arguments->Read("live", &options.live_port);
  if (options.live_port) RequirePage();
  arguments->Read("tiles", &options.tiles);
  if (!options.tiles.empty() && !options.live_port) {
    throw InputError(kCommandLine, "--tiles", options.tiles,
                     "--live with it: its page shows the base map");
  }
  CheckOwnProcesses(options);
  return options;
}

void MarkDriven(const std::vector<DriverPlan>& drivers, Scenario* scenario) {
  for (const DriverPlan& driver : drivers) {
    const std::size_t n = scenario->n_agents(driver.kind);
    if (static_cast<std::size_t>(driver.id) >= n) {
      throw InputError(kCommandLine, "--driver",
                       fmt::format("{}:{}", ToString(driver.kind), driver.id),
                       fmt::format("one of the scenario's {} {}s", n, ToString(driver.kind)));
    }
    auto& agents = ByKind(driver.kind, scenario->uavs, scenario->workers, scenario->vehicles);
    agents[static_cast<std::size_t>(driver.id)].measured = true;
  }
}

std::vector<ProcessPlan> PlanProcesses(const LaunchOptions& options, const Scenario& scenario,
                                       const MissionIdentity& mission) {
  std::vector<ProcessPlan> plans;
  const auto add = [&](const std::string& name, const std::string& role,
                       std::vector<std::string> arguments) {
    const auto named = options.programs.find(name);
    const auto own = named == options.programs.end() ? options.programs.find(role) : named;
    const std::string program = own == options.programs.end() ? "muster-" + role : own->second;
    arguments.insert(arguments.end(), {"--name", name, "--lcm-url", mission.lcm_url, "--run-id",
                                       fmt::to_string(mission.run_id)});
    if (mission.key) arguments.insert(arguments.end(), {"--key", "-"});
    if (options.drop > 0) {
      arguments.insert(arguments.end(), {"--drop", fmt::to_string(options.drop), "--drop-seed",
                                         fmt::to_string(scenario.seed + plans.size())});
    }
    plans.push_back({name, {}, program, std::move(arguments), {}});
  };
  const std::string window = fmt::to_string(WindowOf(options));
  std::vector<std::string> world = {mission.scenario_file, "--rate", options.rate};
  if (options.recorded) {
    world.insert(world.end(), {"--recorder", "--window", fmt::to_string(kWorldWindow)});
    if (options.logger == Logger::kMuster) {
      world.insert(world.end(), {"--window-bytes", fmt::to_string(kWorldWindowBytes)});
    }
  }
  if (options.on_loss != "wait") {
    world.insert(world.end(), {"--on-loss", options.on_loss, "--lost-after",
                               fmt::to_string(options.lost_after_s)});
  }
  const int deciders = Deciders(options);
  if (deciders > 1) world.insert(world.end(), {"--schedulers", fmt::to_string(deciders)});
  for (std::string& option : WorldOptionsOf(options.faults)) world.push_back(std::move(option));
  if (!mission.orders_file.empty()) {
    world.insert(world.end(), {"--orders", mission.orders_file});
  }
  add(process_name::kWorld, process_name::kWorld, std::move(world));
  const std::set<std::string> names = world::SchedulerNames(deciders);
  auto unused = names.begin();  // of a scheduler that is part of no process yet
  for (const AgentKind kind : kAgentKinds) {
    const std::string class_name(ToString(kind));
    const int n = static_cast<int>(scenario.agents(kind).size());
    const int k = options.processes.at(kind);
    if (k > n) {
      throw InputError(kCommandLine, "--processes", fmt::format("{}={}", class_name, k),
                       fmt::format("at most {}, the scenario's {}s", n, class_name));
    }
    for (int i = 0; i < k; ++i) {
      std::vector<std::string> arguments = {"--window", window};
      const int first = n * i / k;
      const int last = n * (i + 1) / k - 1;
      if (k > 1) arguments.insert(arguments.end(), {"--ids", fmt::format("{}-{}", first, last)});
      AddDrivers(options, kind, first, last, &arguments);
      const bool decides = options.schedulers == 0 && !options.programs.contains(class_name);
      if (decides) {
        arguments.insert(arguments.end(), {"--decide-as", *unused, "--policy", options.policy});
      }
      add(k > 1 ? fmt::format("{}-{}", class_name, i + 1) : class_name, class_name,
          std::move(arguments));
      plans.back().agents = AgentBlock{kind, first, last};
      if (decides) plans.back().decides_as = *unused++;
    }
  }
  if (options.schedulers == 0) return plans;
  std::vector<std::string> scheduler = {"--policy", options.policy, "--window", window};
  if (options.deadline_ms) {
    scheduler.insert(scheduler.end(), {"--deadline", fmt::to_string(*options.deadline_ms)});
  }
  for (const std::string& name : names) {
    add(name, process_name::kScheduler, scheduler);
  }
  return plans;
}

}  // namespace muster::tools
