#include "tools/launch/run_command.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "base/say.h"
#include "lcmtypes/bus/multicast.h"
#include "model/agent.h"
#include "model/scenario_json.h"
#include "protocol/fault_kinds.h"
#include "protocol/run_process.h"
#include "tools/files/log_files.h"
#include "tools/files/run_directory.h"
#include "tools/files/scenario_file.h"
#include "tools/host/network_namespace.h"
#include "tools/host/progress.h"
#include "tools/host/stop_signals.h"
#include "tools/launch/launch_options.h"
#include "tools/launch/link_traffic.h"
#include "tools/launch/manifest.h"
#include "tools/launch/mission.h"
#include "tools/live/live_server.h"
#include "tools/orders/order_socket.h"
#include "tools/orders/persons_desk.h"
#include "tools/record/report_json.h"
#include "tools/record/summary.h"
#include "tools/scenario/order_text.h"
#include "tools/tiles/base_map.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOrdersFile = "orders.jsonl";

/// A UDP port that nobody has bound now.
std::uint16_t FreePort() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t size = sizeof address;
  const bool bound = fd >= 0 &&
                     bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                     getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  if (fd >= 0) close(fd);
  if (!bound) throw SystemError("there is no free UDP port");
  return ntohs(address.sin_port);
}

/// The mission's LCM URL; moves this process into a network of its own where that is possible.
std::string FindNetwork(const LaunchOptions& options) {
  if (!options.lcm_url.empty()) return options.lcm_url;
  // Drivers may have to reach what they drive.
  Network network;
  if (!options.drivers.empty()) network = HostNetwork("drivers need the host's network");
  if (network.kind == Network::Kind::kNone) network = EnterPrivateNetwork();
  switch (network.kind) {
    case Network::Kind::kPrivate:
      return MissionUrl(7667);
    case Network::Kind::kHost: {
      std::string url = MissionUrl(FreePort());
      if (!options.quiet) Say("{}; using {}\n", network.detail, url);
      return url;
    }
    case Network::Kind::kNone:
      break;
  }
  throw SystemError(network.detail);
}

/// The folder that this program is in.
fs::path ProgramFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) throw SystemError(fmt::format("cannot read /proc/self/exe: {}", error.message()));
  return self.parent_path();
}

std::string FindLogger() {
  const char* path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? "/usr/bin:/bin" : path;
  while (true) {
    const std::size_t colon = rest.find(':');
    const fs::path program = fs::path(rest.substr(0, colon)) / "lcm-logger";
    if (program.has_parent_path() && access(program.c_str(), X_OK) == 0) return program.string();
    if (colon == std::string_view::npos) break;
    rest.remove_prefix(colon + 1);
  }
  throw SystemError("lcm-logger is not in PATH; Debian has it in the package liblcm-bin");
}

MissionPlan PlanMission(const LaunchOptions& options, const std::vector<ProcessPlan>& processes,
                        const MissionIdentity& mission, const Scenario& scenario) {
  MissionPlan plan;
  plan.restarts.most = options.restarts;
  plan.faults = options.faults;
  plan.goes_on = options.on_loss == "continue";
  plan.lost_after_us = ToUs(options.lost_after_s);
  plan.scenario = scenario;
  if (options.rate != "max") plan.rate = std::stod(options.rate);
  plan.run_id = mission.run_id;
  plan.logger = options.logger;
  for (const ProcessPlan& process : processes) {
    plan.processes.push_back(process.name);
    if (!process.decides_as.empty()) plan.decides_as.emplace(process.name, process.decides_as);
  }
  return plan;
}

MissionPrograms FindPrograms(const LaunchOptions& options,
                             const std::vector<ProcessPlan>& processes,
                             const std::string& lcm_logger, const MissionIdentity& mission,
                             const RunDirectory& directory) {
  MissionPrograms programs;
  programs.hosts = options.hosts;
  programs.lcm_url = mission.lcm_url;
  programs.key = mission.key;
  programs.log_file = directory.File("mission.lcm");
  const fs::path folder = ProgramFolder();
  const std::string logger(NameOf(options.logger));
  programs.logger = {logger, {}, directory.File(logger + ".stderr")};
  std::vector<std::string>& command = programs.logger.argv;
  if (options.logger == Logger::kLcm) {
    // Its fdatasync after each flush would hold the mission wherever the disk is slow or busy.
    programs.logger.disk_waits = DiskWaits::kSkipped;
    command = {lcm_logger, "-q", "--flush-interval=1", "--lcm-url=" + mission.lcm_url};
  } else {
    command = {(folder / "muster-recorder").string(), "--lcm-url", mission.lcm_url, "--run-id",
               fmt::to_string(mission.run_id)};
    if (mission.key) command.insert(command.end(), {"--key", "-"});
  }
  for (const ProcessPlan& process : processes) {
    std::vector<std::string> argv = {(folder / process.program).string()};
    argv.insert(argv.end(), process.arguments.begin(), process.arguments.end());
    programs.processes.push_back(
        {process.name, std::move(argv), directory.File(process.name + ".stderr")});
  }
  return programs;
}

/// For the classes that the user wants to start by hand.
void PrintWhatToStart(const LaunchOptions& options, const MissionIdentity& mission,
                      const RunDirectory& directory) {
  for (const auto& [kind, count] : options.processes) {
    if (count > 0) continue;
    Say("start yourself: {}/muster-{} --lcm-url '{}' --run-id {} --window {}{}\n",
        ProgramFolder().string(), ToString(kind), mission.lcm_url, mission.run_id,
        WindowOf(options),
        mission.key ? fmt::format(" --key '{}'", directory.File(kSealKeyFile)) : "");
  }
}

/// Throws InputError where hosts or faults do not fit the processes of the mission.
void CheckMembers(const Scenario& scenario, LaunchOptions* options) {
  std::vector<std::string> names = {std::string(LauncherNameWith(options->logger))};
  std::map<std::string, std::string> part_of;  // agent processes, by the scheduler in them
  for (const ProcessPlan& process : PlanProcesses(*options, scenario, {})) {
    names.push_back(process.name);
    if (!process.decides_as.empty()) part_of.emplace(process.decides_as, process.name);
  }
  CheckHosts(options->hosts, options->hosts_file, {names.begin() + 1, names.end()},
             options->faults);
  if (options->logger == Logger::kMuster) names.emplace_back(process_name::kRecorder);
  for (const auto& [scheduler, process] : part_of) names.push_back(scheduler);
  CheckFaultPlan(&options->faults, names, scenario, options->on_loss == "continue",
                 options->logger == Logger::kMuster);
  for (const PlannedFault& fault : options->faults) {
    const auto found = part_of.find(fault.target);
    if (found == part_of.end() || RowOf(fault.kind).target != FaultTarget::kProcess) {
      continue;
    }
    throw InputError("command line", "--fault",
                     fmt::format("{} {}", ToString(fault.kind), fault.target),
                     fmt::format("{}, whose process it is part of", found->second));
  }
}

std::optional<SealKey> KeyOf(const LaunchOptions& options, std::int64_t run_id) {
  if (!options.sealed) return {};
  return options.key_file.empty() ? SealKey::Fresh(run_id)
                                  : SealKey::Load(options.key_file).Of(run_id, options.key_file);
}

std::unique_ptr<LossyBus> OpenBusOf(const LaunchOptions& options, const MissionIdentity& mission,
                                    std::uint64_t seed) {
  ProcessFlags flags;
  flags.identity = {mission.run_id, std::string(LauncherNameWith(options.logger)), 0};
  flags.lcm_url = mission.lcm_url;
  flags.drop = options.drop;
  flags.drop_seed = seed;
  if (mission.key) flags.seal.emplace(*mission.key);
  return OpenBus(flags);
}

/// The base map of the live page; null: it has none. Throws InputError where it is one of another
/// place.
std::unique_ptr<const TileFile> TilesOf(const LaunchOptions& options, const Scenario& scenario) {
  if (options.tiles.empty()) return nullptr;
  std::unique_ptr<const TileFile> tiles = OpenTiles(options.tiles);
  BaseMapOf(*tiles, scenario);
  return tiles;
}

/// The orders that are given with the mission, a line each; first who may order at all.
std::string LinesOf(const std::vector<world::PlannedOrder>& orders, PersonsDesk* persons) {
  if (persons == nullptr) return OrderLines(orders);
  return persons->SignedLines(persons->Planned()) + persons->SignedLines(orders);
}

/// The run directory with what is known before the mission: scenario, key, orders, manifest.
RunDirectory MakeDirectory(const LaunchOptions& options, const Scenario& scenario,
                           const std::string& orders, ManifestInput manifest,
                           MissionIdentity* mission) {
  RunDirectory directory =
      options.out.empty()
          ? RunDirectory::MakeNew("runs", RunStem(scenario.name, options.policy, scenario.seed))
          : RunDirectory::Take(options.out);
  manifest.scenario_json = ScenarioToJson(scenario);
  mission->scenario_file = directory.File("scenario.json");
  WriteScenarioFile(scenario, mission->scenario_file);
  if (mission->key) directory.WriteSecret(kSealKeyFile, mission->key->Text());
  if (!orders.empty()) {
    mission->orders_file = directory.File(kOrdersFile);
    directory.Write(kOrdersFile, orders);
  }
  manifest.policy = options.policy;
  manifest.seed = scenario.seed;
  manifest.run_id = mission->run_id;
  manifest.lcm_url = mission->lcm_url;
  manifest.sealed = mission->key.has_value();
  manifest.scenario_file = options.scenario_file;
  directory.Write("manifest.json", ManifestJson(manifest));
  if (!options.quiet) {
    Say("recording in {}\n", directory.path());
    PrintWhatToStart(options, *mission, directory);
  }
  return directory;
}

/// Writes the report, prints the summary and returns the exit code.
int PrintOutcome(const MissionResult& result, const MissionIdentity& mission,
                 const std::optional<LinkTraffic>& traffic, const RunDirectory& directory) {
  PrintProblems(result);
  int code = ExitCodeOf(result);
  try {
    directory.Write("report.json", Report(result.record).dump(2) + "\n");
  } catch (const SystemError& error) {
    Say("muster: {}\n", error.what());
    code = kExitSystem;
  }
  fmt::print("{}", Summary(result.record));
  if (traffic) fmt::print("{}", traffic->Text());
  if (mission.key) {
    fmt::print("{:<14} {} packets without the right tag refused; the key is {}\n", "sealed",
               result.refused, directory.File(kSealKeyFile));
  }
  fmt::print("{:<14} {}\n", "run directory", directory.path());
  return code;
}

}  // namespace

int RunCommand(int argc, const char* const* argv) {
  auto options = ParseLaunchOptions(argc, argv);
  if (!options) return kExitOk;

  // Whatever is wrong with the request or the host is found before the first file is written.
  std::vector<world::PlannedOrder> orders;
  Scenario resolved = ResolveScenario(*options, &orders);
  MarkDriven(options->drivers, &resolved);
  const Scenario scenario = std::move(resolved);
  const std::string lcm_logger = options->logger == Logger::kLcm ? FindLogger() : "";
  CheckMembers(scenario, &*options);
  std::unique_ptr<const TileFile> tiles = TilesOf(*options, scenario);
  const StopSignals stop;
  ManifestInput manifest;
  manifest.command_line = {argv, argv + argc};
  manifest.start_wall_us = HostNow().wall_us;
  MissionIdentity mission;
  mission.run_id = manifest.start_wall_us;
  mission.key = KeyOf(*options, mission.run_id);
  std::optional<PersonsDesk> persons;
  if (!options->persons_file.empty()) {
    persons.emplace(options->persons_file, mission.run_id, manifest.start_wall_us);
  }
  // Before the network: its socket stays in the host's, where the browsers are.
  std::optional<LiveServer> server;
  if (options->live_port) server.emplace(*options->live_port);
  mission.lcm_url = FindNetwork(*options);
  const std::unique_ptr<LossyBus> bus = OpenBusOf(*options, mission, scenario.seed);
  const RunDirectory directory =
      MakeDirectory(*options, scenario, LinesOf(orders, persons ? &*persons : nullptr),
                    std::move(manifest), &mission);

  const std::vector<ProcessPlan> processes = PlanProcesses(*options, scenario, mission);
  MissionPlan plan = PlanMission(*options, processes, mission, scenario);
  const MissionPrograms programs =
      FindPrograms(*options, processes, lcm_logger, mission, directory);
  std::optional<OrderGate> gate;
  std::optional<OrderSocket> orders_socket;
  if (options->takes_orders) {
    gate.emplace(scenario.origin, persons ? &*persons : nullptr);
    orders_socket.emplace(directory.path(), &*gate);
    plan.orders = &*gate;
  }
  std::optional<LiveFeed> feed;
  if (server) {
    feed.emplace(fs::path(directory.path()).filename().string(), std::move(tiles));
    plan.on_logged = [&feed](const Packet& packet) { feed->Add({packet}); };
    server->AnswerAbout(directory.path());
    server->Start(&*feed, options->control ? &*gate : nullptr);
    Say("live at {}\n", server->url());
  }

  std::optional<LinkTraffic> traffic;
  if (!options->hosts.hosts.empty()) {
    traffic.emplace(options->hosts, std::string(kHere));
    plan.on_logged = [&traffic, live = plan.on_logged](const Packet& packet) {
      traffic->Add(packet, MonotonicUs());
      if (live) live(packet);
    };
  }
  ProgressPrinter progress(stderr, StyleFor(stderr, options->quiet));
  const MissionResult result = RunMission(plan, programs, bus.get(), stop, &progress);

  if (gate) gate->Close();
  orders_socket.reset();
  const int code = PrintOutcome(result, mission, traffic, directory);
  if (server && stop.count() == 0) {
    std::fflush(stdout);
    Say("the page stays at {} until Ctrl-C\n", server->url());
    while (stop.count() == 0) poll(nullptr, 0, -1);
  }
  server.reset();
  return code;
}

}  // namespace muster::tools
