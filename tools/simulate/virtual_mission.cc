#include "tools/simulate/virtual_mission.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/program.h"
#include "model/scenario_json.h"
#include "protocol/fault_kinds.h"
#include "protocol/sender.h"
#include "simulation/simulator.h"
#include "simulation/start_process.h"
#include "simulation/virtual_network.h"
#include "simulation/virtual_process.h"
#include "tools/launch/launch_options.h"
#include "tools/record/digest.h"

namespace muster::tools {
namespace {

using simulation::ProcessNames;
using simulation::VirtualBus;
using simulation::VirtualLogger;
using simulation::VirtualNetwork;
using simulation::VirtualProcess;

constexpr std::int64_t kRunId = 1;
constexpr TimeUs kPatienceUs = 30 * kMinuteUs;

/// The plan's failing agents, closed roads and zones, as the world takes them.
world::WorldFaults WorldFaultsIn(const FaultPlan& plan) {
  world::WorldFaults faults;
  for (const PlannedFault& fault : plan) {
    const TimeUs until_us = fault.for_us > 0 ? fault.at_us + fault.for_us : kNever;
    if (RowOf(fault.kind).of_ways()) {
      faults.closures.push_back(
          world::HiddenIn(fault.kind, *CircleFrom(fault.target), fault.at_us, until_us, fault.id));
    }
    if (!RowOf(fault.kind).of_agents()) continue;
    world::Outage& outage = faults.outages.emplace_back();
    const std::size_t colon = fault.target.find(':');
    for (const AgentKind kind : kAgentKinds) {
      if (fault.target.substr(0, colon) == ToString(kind)) outage.kind = kind;
    }
    outage.agent = std::stoi(fault.target.substr(colon + 1));
    outage.from_us = fault.at_us;
    outage.until_us = until_us;
    outage.reason = {world::FailureReason::Cause::kFault, fault.id};
  }
  return faults;
}

/// Cores of processes, a logger and their network, all in virtual time.
class VirtualHost : public MissionHost {
 public:
  explicit VirtualHost(const VirtualMission& mission);

  Now now() const override { return {network_.now_us(), WallUs(process_name::kLauncher)}; }
  Usage usage() const override { return {}; }
  LossyBus& bus() override { return *bus_; }
  int stops_asked() const override;
  bool out_of_patience() const { return network_.now_us() > patience_us_; }

  void Start(const std::string& name, std::int64_t starts) override;
  std::optional<ChildEnd> EndOf(const std::string& name) override;
  void Signal(const std::string& name, int signal) override;
  void AskToEnd(const std::string& name) override;
  void Kill(const std::string& name) override { Signal(name, SIGKILL); }
  bool IsStopped(const std::string& name) const override;
  std::string LastWords(const std::string& name) const override {
    const auto words = last_words_.find(name);
    return words == last_words_.end() ? "" : ": " + words->second;
  }

  void SetDiskFull(bool full) override;
  std::int64_t log_files() const override { return std::ssize(log_files_); }
  std::optional<std::pair<Packet, std::int64_t>> NextLogged() override;
  std::string TornTail(std::int64_t) const override { return ""; }

  void Say(const std::string& line) override {
    if (mission_.say) mission_.say(line);
  }
  void Show(const MissionView&, std::int64_t, bool) override {}

 private:
  struct LogFile {
    std::vector<VirtualLogger::Event> events = {};
    std::size_t read = 0;
  };
  /// What that process's host has as time.
  TimeUs WallUs(const std::string& process) const;
  /// The seed of the draws by which that process loses packets.
  std::uint64_t SeedOf(const std::string& name) const;

  const VirtualMission& mission_;
  TimeUs patience_us_ = kPatienceUs;
  simulation::ProcessSettings settings_;
  VirtualNetwork network_;
  std::unique_ptr<LossyBus> bus_;
  std::map<std::string, std::unique_ptr<VirtualProcess>> processes_;  ///< those that run
  std::map<std::string, ChildEnd> ends_;                              ///< of those that do not
  std::map<std::string, std::string> last_words_;
  std::vector<std::unique_ptr<LogFile>> log_files_;  ///< one a start of the logger
  std::unique_ptr<VirtualLogger> logger_;
};

VirtualHost::VirtualHost(const VirtualMission& mission)
    : mission_(mission), network_(mission.fault_seed) {
  for (const PlannedFault& fault : mission.faults) patience_us_ += fault.for_real_us;
  settings_.scenario = TextOf(mission.scenario);
  settings_.policy = mission.policy;
  settings_.world.recorded = true;
  settings_.world.goes_on = mission.goes_on;
  settings_.world.schedulers = mission.schedulers;
  settings_.world.lost_after_us = mission.lost_after_us;
  settings_.world.faults = WorldFaultsIn(mission.faults);
  settings_.world.orders = mission.orders;
  settings_.drivers = mission.drivers;
  settings_.per_class = mission.per_class;
  for (const AgentKind kind : kAgentKinds) {
    settings_.agents[kind] = static_cast<int>(mission.scenario.agents(kind).size());
  }
  settings_.world_window = kWorldWindow;
  settings_.window = kProcessWindow;
  bus_ = std::make_unique<LossyBus>(std::make_unique<VirtualBus>(&network_), mission.fault_seed,
                                    process_name::kRecorder, [this] { return network_.now_us(); });
  bus_->SetFaults({.loss = mission.drop});
}

int VirtualHost::stops_asked() const {
  const int asked = mission_.stops_asked ? mission_.stops_asked() : 0;
  return std::max(asked, out_of_patience() ? 1 : 0);
}

TimeUs VirtualHost::WallUs(const std::string& process) const {
  TimeUs wall_us = mission_.epoch_us + network_.now_us();
  for (const ClockJump& jump : mission_.clock_jumps) {
    if (jump.process == process && jump.at_us <= network_.now_us()) wall_us += jump.by_us;
  }
  return wall_us;
}

std::uint64_t VirtualHost::SeedOf(const std::string& name) const {
  const std::vector<std::string> names = ProcessNames(mission_.schedulers, mission_.per_class);
  const auto place = std::find(names.begin(), names.end(), name) - names.begin();
  return mission_.fault_seed + static_cast<std::uint64_t>(place);
}

void VirtualHost::Start(const std::string& name, std::int64_t starts) {
  ends_.erase(name);
  if (name == process_name::kLogger) {
    log_files_.push_back(std::make_unique<LogFile>());
    logger_.reset();
    logger_ = std::make_unique<VirtualLogger>(&network_, &log_files_.back()->events);
    return;
  }
  processes_.erase(name);
  processes_[name] = std::make_unique<VirtualProcess>(
      &network_, simulation::StartProcess({kRunId, name, starts}, settings_), SeedOf(name),
      PacketFaults{.loss = mission_.drop}, [this, name] { return WallUs(name); });
}

std::optional<ChildEnd> VirtualHost::EndOf(const std::string& name) {
  if (name == process_name::kLogger && logger_ && logger_->died()) {
    logger_.reset();
    ends_[name] = {SIGXFSZ};
  }
  const auto process = processes_.find(name);
  if (process != processes_.end() && !process->second->failure().empty()) {
    last_words_[name] = process->second->failure();
    processes_.erase(process);
    ends_[name] = {W_EXITCODE(kExitUsage, 0)};
  }
  const auto end = ends_.find(name);
  return end == ends_.end() ? std::nullopt : std::optional(end->second);
}

void VirtualHost::Signal(const std::string& name, int signal) {
  if (EndOf(name)) return;
  const bool is_logger = name == process_name::kLogger;
  if (signal == SIGKILL) {
    is_logger ? logger_.reset() : static_cast<void>(processes_.erase(name));
    ends_[name] = {SIGKILL};
    return;
  }
  MUSTER_CHECK(signal == SIGSTOP || signal == SIGCONT, "signal {}", signal);
  const bool stopped = signal == SIGSTOP;
  is_logger ? logger_->set_stopped(stopped) : processes_.at(name)->set_stopped(stopped);
}

void VirtualHost::AskToEnd(const std::string& name) {
  if (name == process_name::kLogger) {
    logger_->set_stopped(false);
    logger_->End();
    if (EndOf(name)) return;
    logger_.reset();
  } else {
    processes_.erase(name);
  }
  ends_[name] = {0};
}

bool VirtualHost::IsStopped(const std::string& name) const {
  if (name == process_name::kLogger) return logger_ && logger_->stopped();
  const auto process = processes_.find(name);
  return process != processes_.end() && process->second->stopped();
}

void VirtualHost::SetDiskFull(bool full) {
  if (logger_) logger_->set_disk_full(full);
}

std::optional<std::pair<Packet, std::int64_t>> VirtualHost::NextLogged() {
  for (std::size_t i = 0; i < log_files_.size(); ++i) {
    LogFile& file = *log_files_[i];
    if (file.read == file.events.size()) {
      file.events.clear();
      file.read = 0;
      continue;
    }
    const VirtualLogger::Event event = std::move(file.events[file.read++]);
    const auto start = static_cast<std::int64_t>(i);
    if (mission_.on_logged) mission_.on_logged(event, start);
    return std::pair(*event.packet, start);
  }
  return {};
}

}  // namespace

std::string UndisturbedDigest(const VirtualMission& mission) {
  RunRecord record;
  Simulate(
      TextOf(mission.scenario), mission.policy, [&](const Packet& packet) { record.Add(packet); },
      WorldFaultsIn(mission.faults), mission.orders);
  return Digest(record);
}

MissionResult RunVirtualMission(const VirtualMission& mission) {
  MissionPlan plan;
  plan.run_id = kRunId;
  // What it has not written when it dies is lost: the harder of the two for everybody else.
  plan.logger = Logger::kLcm;
  plan.scenario = mission.scenario;
  plan.processes = ProcessNames(mission.schedulers, mission.per_class);
  plan.restarts = mission.restarts;
  plan.faults = mission.faults;
  plan.goes_on = mission.goes_on;
  plan.lost_after_us = mission.lost_after_us;
  VirtualHost host(mission);
  MissionResult result = Supervise(plan, &host);
  if (result.end == MissionEnd::kInterrupted && host.out_of_patience()) {
    result.end = MissionEnd::kFailed;
    result.problems.push_back(
        fmt::format("the mission has not ended after {:.0f} s of network time",
                    ToSeconds(host.now().monotonic_us)));
  }
  return result;
}

}  // namespace muster::tools
