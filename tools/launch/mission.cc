#include "tools/launch/mission.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "base/check.h"
#include "base/say.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/multicast.h"
#include "protocol/run_process.h"
#include "tools/host/child_guard.h"

namespace muster::tools {
namespace {

constexpr TimeUs kGuardUs = 2 * kSecondUs;
constexpr TimeUs kGuardLookUs = 100;
constexpr int kLastWords = 5;                  // lines
constexpr std::uint64_t kRoomBytes = 1 << 20;  // less is no room for a log

/// Children of this process, LCM, files.
class RealHost : public MissionHost {
 public:
  RealHost(const MissionPrograms& programs, LossyBus* bus, const StopSignals& stop,
           ProgressPrinter* progress)
      : programs_(programs), hosts_(programs.hosts), bus_(bus), stop_(stop), progress_(progress) {
    for (const std::string& file : programs.earlier_logs) log_files_.push_back({file});
  }

  Now now() const override { return HostNow(); }
  Usage usage() const override { return HostUsage(); }
  LossyBus& bus() override { return *bus_; }
  void OnNetworkBack() override;
  int stops_asked() const override { return stop_.count(); }

  void Start(const std::string& name, std::int64_t starts) override;
  std::optional<ChildEnd> EndOf(const std::string& name) override { return Find(name).Poll(); }
  void Signal(const std::string& name, int signal) override { Find(name).Signal(signal); }
  void AskToEnd(const std::string& name) override { Find(name).AskToEnd(); }
  void Kill(const std::string& name) override { children_.erase(name); }
  bool IsStopped(const std::string& name) const override;
  std::vector<std::string> OnHostWithStandby(const std::string& name) const override;
  std::string MoveToStandby(const std::string& name) override;
  std::string LastWords(const std::string& name) const override;

  std::string NoRoom() const override;
  void SetDiskFull(bool full) override;
  std::int64_t log_files() const override { return std::ssize(log_files_); }
  std::optional<std::pair<Packet, std::int64_t>> NextLogged() override;
  std::string TornTail(std::int64_t file) const override;

  void Say(const std::string& line) override;
  void Show(const MissionView& logged, std::int64_t lag_ticks, bool at_end) override;

 private:
  struct LogFile {
    std::string path;
    std::unique_ptr<EventLogReader> reader = {};
  };
  Child& Find(const std::string& name);
  void GuardLogger();
  bool is_logger(const std::string& name) const { return name == programs_.logger.name; }
  /// Stock lcm-logger knows nothing of us; our recorder sees to itself.
  bool has_stock_logger() const { return is_logger(process_name::kLogger); }
  const ChildSpec& SpecOf(const std::string& name) const;

  const MissionPrograms& programs_;
  HostList hosts_;  ///< as they stand: processes of hosts that are gone are on their standbys
  LossyBus* bus_;
  const StopSignals& stop_;
  ProgressPrinter* progress_;
  std::map<std::string, Child> children_;  ///< the present start of each, or the last one
  std::vector<LogFile> log_files_;         ///< one a start of the logger
  std::optional<TimeUs> started_us_;       ///< when the mission was first seen to run
};

Child& RealHost::Find(const std::string& name) {
  const auto found = children_.find(name);
  MUSTER_CHECK(found != children_.end(), "{}", name);
  return found->second;
}

const ChildSpec& RealHost::SpecOf(const std::string& name) const {
  if (is_logger(name)) return programs_.logger;
  const auto found = std::find_if(programs_.processes.begin(), programs_.processes.end(),
                                  [&](const ChildSpec& spec) { return spec.name == name; });
  MUSTER_CHECK(found != programs_.processes.end(), "{}", name);
  return *found;
}

void RealHost::Start(const std::string& name, std::int64_t starts) {
  ChildSpec spec = SpecOf(name);
  spec.append = starts > 0;
  if (is_logger(name)) {
    if (!has_stock_logger()) {
      for (const LogFile& file : log_files_) {
        spec.argv.insert(spec.argv.end(), {"--after", file.path});
      }
    }
    // Always a new file: behind a torn event, what follows would be hidden.
    log_files_.push_back({log_files_.empty()
                              ? programs_.log_file
                              : fmt::format("{}.{}", programs_.log_file, log_files_.size())});
    spec.argv.push_back(log_files_.back().path);
  }
  if (name != process_name::kLogger) {
    spec.argv.insert(spec.argv.end(), {"--boot-id", fmt::to_string(starts)});
    if (const Host* host = hosts_.Of(name)) spec = OnHost(*host, std::move(spec));
  }
  children_.erase(name);
  children_.emplace(name, std::move(spec));
  if (name == process_name::kLogger) GuardLogger();
}

/// Stock lcm-logger does not guard its socket: it is looked for until it is there.
void RealHost::GuardLogger() {
  const std::uint16_t port = ParseMulticastUrl(programs_.lcm_url).port;
  const TimeUs deadline_us = MonotonicUs() + kGuardUs;
  Child& logger = Find(process_name::kLogger);
  std::string problem = "it has opened none";
  try {
    while (!logger.Poll() && MonotonicUs() < deadline_us) {
      if (GuardSocketsOf(logger.pid(), port)) return;
      usleep(kGuardLookUs);
    }
  } catch (const SystemError& error) {
    problem = error.what();
  }
  if (logger.Poll()) return;
  Say(fmt::format("nothing checks what comes to lcm-logger's socket: {}", problem));
}

void RealHost::OnNetworkBack() {
  if (!has_stock_logger()) return;
  const MulticastUrl url = ParseMulticastUrl(programs_.lcm_url);
  const auto logger = children_.find(process_name::kLogger);
  if (logger == children_.end() || logger->second.Poll()) return;
  try {
    RejoinSocketsOf(logger->second.pid(), url.port, url.address);
  } catch (const SystemError& error) {
    Say(fmt::format("lcm-logger may hear nothing: {}", error.what()));
  }
}

std::vector<std::string> RealHost::OnHostWithStandby(const std::string& name) const {
  const Host* host = hosts_.Of(name);
  return host == nullptr || host->standby.empty() ? std::vector<std::string>() : host->processes;
}

std::string RealHost::MoveToStandby(const std::string& name) {
  const Host host = *hosts_.Of(name);
  hosts_.MoveToStandby(host.name);
  return fmt::format("host {} is gone: {} {} on {} from now on", host.name,
                     fmt::join(host.processes, ", "), host.processes.size() == 1 ? "runs" : "run",
                     host.standby);
}

bool RealHost::IsStopped(const std::string& name) const {
  const auto found = children_.find(name);
  return found != children_.end() && found->second.Stopped();
}

std::string RealHost::LastWords(const std::string& name) const {
  const std::string& file = SpecOf(name).output_file;
  const std::string words = LastLines(file, kLastWords);
  return words.empty() ? fmt::format("; {} is empty", file)
                       : fmt::format("; {} ends with:\n{}", file, words);
}

std::string RealHost::NoRoom() const {
  std::filesystem::path folder = std::filesystem::path(programs_.log_file).parent_path();
  if (folder.empty()) folder = ".";
  struct statvfs disk = {};
  if (statvfs(folder.c_str(), &disk) != 0 || disk.f_bavail * disk.f_frsize >= kRoomBytes) return "";
  return fmt::format("the disk of {} is full", folder.string());
}

void RealHost::SetDiskFull(bool full) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(log_files_.back().path, error);
  rlimit limit = {RLIM_INFINITY, RLIM_INFINITY};
  if (full) limit.rlim_cur = error ? 0 : static_cast<rlim_t>(size);
  if (prlimit(Find(programs_.logger.name).pid(), RLIMIT_FSIZE, &limit, nullptr) != 0 &&
      errno != ESRCH) {
    throw SystemError(fmt::format("cannot limit the log's size: {}", std::strerror(errno)));
  }
}

std::optional<std::pair<Packet, std::int64_t>> RealHost::NextLogged() {
  for (std::size_t i = 0; i < log_files_.size(); ++i) {
    LogFile& file = log_files_[i];
    if (!file.reader) {
      if (!std::filesystem::exists(file.path)) continue;
      file.reader = std::make_unique<EventLogReader>(file.path, EventLogReader::Tail::kMayGrow);
      if (programs_.seal) file.reader->OnlyWith(programs_.seal);
    }
    if (std::optional<LogEvent> event = file.reader->Next()) {
      // What has a tag in a mission that is not sealed is no message of it.
      if (!programs_.seal) event->packet = WithTag(std::move(event->packet), event->tag);
      return std::pair(std::move(event->packet), static_cast<std::int64_t>(i));
    }
  }
  return {};
}

std::string RealHost::TornTail(std::int64_t file) const {
  const auto& [path, reader] = log_files_[static_cast<std::size_t>(file)];
  if (!reader) return "";
  const std::int64_t bytes = reader->pending_bytes() + reader->garbage_bytes();
  return bytes == 0 ? "" : fmt::format("{}: {} bytes belong to no event", path, bytes);
}

void RealHost::Say(const std::string& line) {
  progress_->Break();
  muster::Say("muster: {}\n", line);
}

void RealHost::Show(const MissionView& logged, std::int64_t lag_ticks, bool at_end) {
  const TimeUs now_us = MonotonicUs();
  if (!started_us_ && logged.started()) started_us_ = now_us;
  if (progress_->due(at_end ? kNever : now_us)) {
    progress_->Show(ProgressLine(logged, lag_ticks, now_us - started_us_.value_or(now_us)), now_us);
  }
  if (at_end) progress_->Break();
}

}  // namespace

MissionResult RunMission(const MissionPlan& plan, const MissionPrograms& programs, LossyBus* bus,
                         const StopSignals& stop, ProgressPrinter* progress) {
  RealHost host(programs, bus, stop, progress);
  return Supervise(plan, &host);
}

}  // namespace muster::tools
