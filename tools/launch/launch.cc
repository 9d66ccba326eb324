#include "tools/launch/launch.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iterator>
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
#include "protocol/fault_kinds.h"
#include "protocol/run_process.h"
#include "tools/files/log_files.h"
#include "tools/host/network_namespace.h"
#include "tools/host/progress.h"
#include "tools/launch/link_traffic.h"
#include "tools/launch/mission.h"
#include "tools/launch/second_log.h"
#include "tools/live/live_server.h"
#include "tools/orders/order_socket.h"
#include "tools/record/report_json.h"
#include "tools/record/summary.h"
#include "tools/tiles/tiles_beside.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

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
                        const MissionIdentity& mission, const Scenario& scenario,
                        const EarlierRun& earlier) {
  MissionPlan plan;
  plan.restarts.most = options.restarts;
  std::copy_if(options.faults.begin(), options.faults.end(), std::back_inserter(plan.faults),
               [&](const PlannedFault& fault) { return fault.at_us > earlier.tick_us; });
  plan.starts = earlier.starts;
  plan.first_boot = earlier.first_boot;
  plan.goes_on = options.on_loss == "continue";
  plan.lost_after_us = ToUs(options.lost_after_s);
  plan.scenario = scenario;
  if (options.rate != "max") plan.rate = std::stod(options.rate);
  plan.run_id = mission.run_id;
  plan.logger = options.logger;
  plan.has_second_log = !options.second_log.empty();
  for (const ProcessPlan& process : processes) {
    plan.processes.push_back(process.name);
    if (!process.decides_as.empty()) plan.decides_as.emplace(process.name, process.decides_as);
  }
  return plan;
}

/// `first`: the first recorder's command line, without its file.
ChildSpec SecondRecorder(std::vector<std::string> first, const std::string& folder,
                         const RunDirectory& directory) {
  const std::string name = process_name::kSecondRecorder;
  first.insert(first.end(), {"--name", name, "--into", folder});
  return {name, std::move(first), directory.File(name + ".stderr")};
}

MissionPrograms FindPrograms(const Launch& launch, const std::vector<ProcessPlan>& processes,
                             const RunDirectory& directory) {
  const LaunchOptions& options = launch.options;
  const MissionIdentity& mission = launch.mission;
  MissionPrograms programs;
  programs.hosts = options.hosts;
  programs.earlier_logs = launch.earlier.log_files;
  programs.lcm_url = mission.lcm_url;
  const auto key_for = [&launch](const std::string& process) {
    return launch.seal ? launch.seal->KeyFor(process) : "";
  };
  if (launch.seal) programs.seal = launch.seal->seal();
  programs.log_file = directory.File("mission.lcm");
  const fs::path folder = ProgramFolder();
  const std::string logger(NameOf(options.logger));
  programs.logger = {logger, {}, directory.File(logger + ".stderr")};
  std::vector<std::string>& command = programs.logger.argv;
  if (options.logger == Logger::kLcm) {
    // Its fdatasync after each flush would hold the mission wherever the disk is slow or busy.
    programs.logger.disk_waits = DiskWaits::kSkipped;
    command = {launch.lcm_logger, "-q", "--flush-interval=1", "--lcm-url=" + mission.lcm_url};
  } else {
    command = {(folder / "muster-recorder").string(), "--lcm-url", mission.lcm_url, "--run-id",
               fmt::to_string(mission.run_id)};
    if (mission.key) command.insert(command.end(), {"--key", "-"});
    command.insert(command.end(), {"--first-boot", fmt::to_string(launch.earlier.first_boot)});
    if (!options.second_log.empty()) {
      programs.processes.push_back(SecondRecorder(command, options.second_log, directory));
      programs.processes.back().input = key_for(process_name::kSecondRecorder);
      command.insert(command.end(), {"--second-after", fmt::to_string(options.lost_after_s)});
    }
  }
  if (options.logger == Logger::kMuster) programs.logger.input = key_for(logger);
  for (const ProcessPlan& process : processes) {
    std::vector<std::string> argv = {(folder / process.program).string()};
    argv.insert(argv.end(), process.arguments.begin(), process.arguments.end());
    programs.processes.push_back(
        {process.name, std::move(argv), directory.File(process.name + ".stderr")});
    programs.processes.back().input = key_for(process.name);
  }
  return programs;
}

/// Throws InputError where hosts or faults do not fit the processes of the mission.
void CheckMembers(const Scenario& scenario, LaunchOptions* options) {
  std::vector<std::string> names = {std::string(LauncherNameWith(options->logger))};
  std::map<std::string, std::string> part_of;  // agent processes, by the scheduler in them
  for (const ProcessPlan& process : PlanProcesses(*options, scenario, {})) {
    names.push_back(process.name);
    if (!process.decides_as.empty()) part_of.emplace(process.decides_as, process.name);
  }
  if (!options->second_log.empty()) names.emplace_back(process_name::kSecondRecorder);
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
                     fmt::format("{}: the target runs inside that process", found->second));
  }
}

std::unique_ptr<LossyBus> OpenBusOf(const Launch& launch) {
  const LaunchOptions& options = launch.options;
  const MissionIdentity& mission = launch.mission;
  const std::string name(LauncherNameWith(options.logger));
  ProcessFlags flags;
  flags.identity = {mission.run_id, name, launch.earlier.StartsOf(name)};
  flags.lcm_url = mission.lcm_url;
  flags.drop = options.drop;
  flags.drop_seed = launch.scenario.seed;
  if (launch.seal) flags.seal = launch.seal->seal();
  return OpenBus(flags);
}

/// The base map of the live page; null: it has none. Throws InputError where one that was asked for
/// is of another place.
std::unique_ptr<const TileFile> TilesOf(const LaunchOptions& options, const Scenario& scenario) {
  if (!options.live_port) return nullptr;
  const std::string file =
      options.tiles.empty() ? TilesBeside(options.scenario_file) : options.tiles;
  if (file.empty() || file == kNoTiles) return nullptr;
  try {
    std::unique_ptr<const TileFile> tiles = OpenTiles(file);
    BaseMapOf(*tiles, scenario);
    return tiles;
  } catch (const InputError& error) {
    if (!options.tiles.empty()) throw;
    Say("no base map: {}\n", error.what());
    return nullptr;
  }
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

/// " --key FILE" of a process that is started by hand; "": the mission is not sealed.
std::string KeyOption(const MissionIdentity& mission, std::string_view process,
                      const RunDirectory& directory) {
  if (!mission.key) return "";
  return fmt::format(" --key '{}'",
                     directory.File(mission.key->per_process
                                        ? fmt::format("{}/{}.key", kProcessKeysFolder, process)
                                        : std::string(kSealKeyFile)));
}

}  // namespace

/// For the classes that the user wants to start by hand.
void PrintWhatToStart(const LaunchOptions& options, const MissionIdentity& mission,
                      const RunDirectory& directory) {
  for (const auto& [kind, count] : options.processes) {
    if (count > 0) continue;
    Say("start yourself: {}/muster-{} --lcm-url '{}' --run-id {} --window {}{}\n",
        ProgramFolder().string(), ToString(kind), mission.lcm_url, mission.run_id,
        WindowOf(options), KeyOption(mission, ToString(kind), directory));
  }
}

void PrepareLaunch(Launch* launch) {
  launch->lcm_logger = launch->options.logger == Logger::kLcm ? FindLogger() : "";
  CheckMembers(launch->scenario, &launch->options);
  const std::string& second = launch->options.second_log;
  const Host* host = launch->options.hosts.Of(process_name::kSecondRecorder);
  if (!second.empty() && launch->earlier.log_files.empty() &&
      (host == nullptr || host->ssh.empty())) {
    CheckSecondFolder(second);
  }
  launch->tiles = TilesOf(launch->options, launch->scenario);
}

namespace {

/// Where a mission fails before anything was logged, nothing is left of it.
class LeavesNothing {
 public:
  explicit LeavesNothing(const RunDirectory* directory) : directory_(directory) {}
  ~LeavesNothing() {
    if (std::uncaught_exceptions() > before_) directory_->RemoveWithoutLog();
  }
  LeavesNothing(const LeavesNothing&) = delete;
  LeavesNothing& operator=(const LeavesNothing&) = delete;

 private:
  const RunDirectory* directory_;
  const int before_ = std::uncaught_exceptions();
};

}  // namespace

int Conduct(Launch* launch, const StopSignals& stop,
            const std::function<RunDirectory(MissionIdentity*)>& directory_of) {
  const LaunchOptions& options = launch->options;
  const Scenario& scenario = launch->scenario;
  MissionIdentity& mission = launch->mission;
  // Before the network: its socket stays in the host's, where the browsers are.
  std::optional<LiveServer> server;
  if (options.live_port) server.emplace(*options.live_port);
  if (mission.key) {
    launch->seal.emplace(*mission.key, options, scenario, PlanProcesses(options, scenario, {}));
  }
  mission.lcm_url = FindNetwork(options);
  const std::unique_ptr<LossyBus> bus = OpenBusOf(*launch);
  const RunDirectory directory = directory_of(&mission);
  const LeavesNothing on_failure(&directory);
  if (!launch->lock) launch->lock.emplace(directory.path());

  if (!options.second_log.empty()) {
    FillSecondFolder(directory, options.second_log,
                     options.hosts.Of(process_name::kSecondRecorder));
  }
  const std::vector<ProcessPlan> processes = PlanProcesses(options, scenario, mission);
  MissionPlan plan = PlanMission(options, processes, mission, scenario, launch->earlier);
  const MissionPrograms programs = FindPrograms(*launch, processes, directory);
  std::optional<OrderGate> gate;
  std::optional<OrderSocket> orders_socket;
  if (options.takes_orders) {
    gate.emplace(scenario.origin, launch->persons ? &*launch->persons : nullptr);
    orders_socket.emplace(directory.path(), &*gate);
    plan.orders = &*gate;
  }
  std::optional<LiveFeed> feed;
  if (server) {
    feed.emplace(fs::path(directory.path()).filename().string(), std::move(launch->tiles));
    plan.on_logged = [&feed](const Packet& packet) { feed->Add({packet}); };
    server->AnswerAbout(directory.path());
    server->Start(&*feed, options.control ? &*gate : nullptr);
    Say("live at {}\n", server->url());
  }

  std::optional<LinkTraffic> traffic;
  if (!options.hosts.hosts.empty()) {
    traffic.emplace(options.hosts, std::string(kHere));
    plan.on_logged = [&traffic, live = plan.on_logged](const Packet& packet) {
      traffic->Add(packet, MonotonicUs());
      if (live) live(packet);
    };
  }
  ProgressPrinter progress(stderr, StyleFor(stderr, options.quiet));
  const MissionResult result = RunMission(plan, programs, bus.get(), stop, &progress);

  if (gate) gate->Close();
  orders_socket.reset();
  const int code = PrintOutcome(result, mission, traffic, directory);
  if (server && stop.count() == 0) {
    std::fflush(stdout);
    Say("the page stays at {} until Ctrl-C\n", server->url());
    while (stop.count() == 0) poll(nullptr, 0, -1);
  }
  return code;
}

}  // namespace muster::tools
