#include "tools/bench/mission_runs.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <muster/clock_t.hpp>
#include <muster/process_status_t.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/multicast.h"
#include "lcmtypes/channels.h"
#include "model/scenario_json.h"
#include "protocol/run_process.h"
#include "tools/files/pending_file.h"
#include "tools/host/child.h"
#include "tools/host/network_namespace.h"
#include "tools/launch/launch_options.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint16_t kPort = 7667;
constexpr useconds_t kLookUs = 5'000;
constexpr TimeUs kLongestUs = 60 * kMinuteUs;  // of one mission, wall time
constexpr TimeUs kEndUs = 10 * kSecondUs;      // to end when asked to
constexpr std::string_view kSimulate = "simulate";

/// Of all children that have been waited for, and theirs.
rusage ChildrenUsage() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage;
}

double CpuSeconds(const rusage& usage) {
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// None: it had to be killed.
std::optional<ChildEnd> WaitFor(Child* child, TimeUs longest_us) {
  const TimeUs deadline_us = MonotonicUs() + longest_us;
  while (!child->Poll()) {
    if (MonotonicUs() >= deadline_us) {
      child->AskToEnd();
      const TimeUs killed_us = MonotonicUs() + kEndUs;
      while (!child->Poll() && MonotonicUs() < killed_us) usleep(kLookUs);
      return std::nullopt;
    }
    usleep(kLookUs);
  }
  return child->Poll();
}

/// `muster` itself, with `arguments` and --out FOLDER/run.
std::string RunMuster(std::vector<std::string> arguments, const std::string& folder) {
  arguments.insert(arguments.begin(), fs::read_symlink("/proc/self/exe").string());
  arguments.insert(arguments.end(), {"--quiet", "--out", folder + "/run"});
  Child muster({"muster", std::move(arguments), folder + "/muster.output"});
  const auto end = WaitFor(&muster, kLongestUs);
  if (!end) return "did not end";
  return end->clean() ? "complete" : end->Text();
}

void AddKind(const std::string& process, double cpu_s, std::int64_t peak_bytes,
             MissionFigures* figures) {
  KindUsage& kind = figures->kinds[KindOf(process)];
  kind.cpu_s += cpu_s;
  kind.peak_bytes = std::max(kind.peak_bytes, peak_bytes);
}

/// What report.json says of a mission over LCM, and its log.
void ReadRun(const MissionSetting& setting, const std::string& run, MissionFigures* figures) {
  const Json report = Json::parse(ReadFile(run + "/report.json"), nullptr, false);
  if (report.is_discarded()) return;
  figures->wall_s = report["wall_s"].get<double>();
  figures->digest = report["digest"].get<std::string>();
  figures->log_messages = report["log"]["messages"].get<std::int64_t>();
  figures->log_doubles = report["log"]["duplicates"].get<std::int64_t>();
  for (const Json& process : report["processes"]) {
    std::string name = process["name"].get<std::string>();
    // Where lcm-logger writes, the launcher speaks as the recorder.
    if (setting.run == "lcm" && name == process_name::kRecorder) name = process_name::kLauncher;
    AddKind(name, process["cpu_s"].get<double>(), process["rss_bytes"].get<std::int64_t>(),
            figures);
    figures->resent += process["resent"].get<std::int64_t>();
  }
  for (const auto& entry : fs::directory_iterator(run)) {
    if (entry.path().filename().string().starts_with("mission.lcm")) {
      figures->log_bytes += static_cast<std::int64_t>(entry.file_size());
    }
  }
}

/// A mission whose processes wait for no log: what `muster run` starts, without recorder and
/// launcher. A listener waits for its end.
class UnloggedMission {
 public:
  UnloggedMission(const MissionSetting& setting, std::string folder)
      : setting_(setting), folder_(std::move(folder)) {}

  void Run(MissionFigures* figures) {
    LaunchOptions options;
    options.policy = setting_.policy;
    options.rate = "max";
    for (const AgentKind kind : kAgentKinds) options.processes[kind] = setting_.processes;
    options.recorded = false;
    MissionIdentity mission;
    mission.scenario_file = setting_.scenario_file;
    mission.lcm_url = MissionUrl(kPort);
    mission.run_id = 1;
    ProcessFlags flags;
    flags.identity = {mission.run_id, "bench", 0};
    flags.lcm_url = mission.lcm_url;
    LcmTap tap;
    for (const std::string_view heard : {channel::kClock, channel::kProcess}) {
      tap.heard.emplace_back(heard);
    }
    tap.on_message = [](const Packet&) {};
    tap.on_burst = [] {};
    const auto bus = OpenBus(flags, GuardedChannels::kOurs, tap);
    const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
    std::vector<Child> children;
    for (const ProcessPlan& process :
         PlanProcesses(options, LoadScenario(setting_.scenario_file), mission)) {
      std::vector<std::string> argv = {(programs / process.program).string()};
      argv.insert(argv.end(), process.arguments.begin(), process.arguments.end());
      children.emplace_back(
          ChildSpec{process.name, std::move(argv), folder_ + "/" + process.name + ".output"});
    }
    const TimeUs deadline_us = MonotonicUs() + kLongestUs;
    while (figures->end == "complete" && ended_ < children.size()) {
      for (const Packet& packet : bus->Receive(kSecondUs / 10)) Hear(packet);
      for (Child& child : children) {
        if (child.Poll()) figures->end = child.spec().name + " " + child.Poll()->Text();
      }
      if (MonotonicUs() >= deadline_us) figures->end = "did not end";
    }
    for (Child& child : children) child.AskToEnd();
    for (Child& child : children) WaitFor(&child, kEndUs);
    figures->wall_s = ToSeconds(last_wall_us_ - first_wall_us_);
    for (const auto& [name, status] : statuses_) {
      AddKind(name, status.cpu_s, status.rss_bytes, figures);
      figures->resent += status.resent;
    }
  }

 private:
  void Hear(const Packet& packet) {
    if (packet.channel == channel::kClock) {
      const auto clock = DecodeValid<muster::clock_t>(packet.bytes);
      if (!clock) return;
      if (first_wall_us_ == 0) first_wall_us_ = clock->header.wall_us;
      last_wall_us_ = std::max(last_wall_us_, clock->header.wall_us);
    } else if (const auto status = DecodeValid<process_status_t>(packet.bytes)) {
      statuses_[status->name] = *status;
      const auto has_ended = [](const auto& entry) {
        return entry.second.state == NumberOf(ProcessState::kEnded);
      };
      ended_ =
          static_cast<std::size_t>(std::count_if(statuses_.begin(), statuses_.end(), has_ended));
    }
  }

  const MissionSetting& setting_;
  const std::string folder_;
  std::map<std::string, process_status_t> statuses_;
  std::size_t ended_ = 0;
  std::int64_t first_wall_us_ = 0, last_wall_us_ = 0;
};

/// Fills in what the kernel has counted since the network was made.
void ReadNetwork(MissionFigures* figures) {
  const std::string udp = ReadFile("/proc/self/net/snmp");
  const std::string ip = ReadFile("/proc/self/net/netstat");
  figures->sent_datagrams = KernelCounter(udp, "Udp", "OutDatagrams");
  figures->received_datagrams = KernelCounter(udp, "Udp", "InDatagrams");
  figures->buffer_errors = KernelCounter(udp, "Udp", "RcvbufErrors");
  figures->sent_bytes = KernelCounter(ip, "IpExt", "OutOctets");
}

}  // namespace

std::int64_t KernelCounter(std::string_view table, std::string_view protocol,
                           std::string_view name) {
  std::istringstream lines{std::string(table)};
  std::string names, numbers;
  while (std::getline(lines, names) && std::getline(lines, numbers)) {
    std::istringstream keys(names), values(numbers);
    std::string key, value;
    if (!(keys >> key && values >> value) || key != fmt::format("{}:", protocol)) continue;
    while (keys >> key && values >> value) {
      if (key == name) return std::stoll(value);
    }
  }
  return -1;
}

std::string KindOf(const std::string& process) {
  const std::size_t dash = process.rfind('-');
  const bool numbered = dash != std::string::npos && dash + 1 < process.size() &&
                        process.find_first_not_of("0123456789", dash + 1) == std::string::npos;
  return numbered ? process.substr(0, dash) : process;
}

MissionFigures RunMeasured(const MissionSetting& setting, const std::string& folder) {
  const Network network = EnterPrivateNetwork();
  if (network.kind != Network::Kind::kPrivate) {
    throw SystemError(fmt::format("no network of the mission's own ({})", network.detail));
  }
  MissionFigures figures;
  if (setting.run == kSimulate) {
    const TimeUs start_us = MonotonicUs();
    figures.end =
        RunMuster({"simulate", setting.scenario_file, "--policy", setting.policy}, folder);
    const double wall_s = ToSeconds(MonotonicUs() - start_us);
    ReadRun(setting, folder + "/run", &figures);
    figures.wall_s = wall_s;
    figures.kinds.clear();
    const rusage usage = ChildrenUsage();
    AddKind(std::string(kSimulate), CpuSeconds(usage), usage.ru_maxrss * 1024, &figures);
    figures.resent = figures.log_messages = figures.log_doubles = 0;
  } else if (setting.run == "none") {
    UnloggedMission(setting, folder).Run(&figures);
  } else {
    const int n = setting.processes;
    figures.end =
        RunMuster({"run", setting.scenario_file, "--policy", setting.policy, "--logger",
                   setting.run, "--lcm-url", MissionUrl(kPort), "--processes",
                   n == 1 ? "uav=1" : fmt::format("uav={},worker={},vehicle={}", n, n, n)},
                  folder);
    ReadRun(setting, folder + "/run", &figures);
  }
  figures.cpu_s = CpuSeconds(ChildrenUsage());
  if (setting.run != kSimulate) ReadNetwork(&figures);
  return figures;
}

}  // namespace muster::tools
