#include "protocol/run_process.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "base/beside.h"
#include "base/check.h"
#include "base/program.h"
#include "base/say.h"
#include "base/text.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/member_keys.h"
#include "protocol/drive.h"
#include "protocol/outage_watch.h"
#include "protocol/refusal_watch.h"

namespace muster {
namespace {

/// A process that computes says so often: --lost-after may be half a second.
constexpr TimeUs kBeatUs = 150'000;
/// How long it then waits for packets before it looks whether the computation has ended.
constexpr TimeUs kLookUs = 5'000;
/// Packets that are kept for the end of a computation; the rest waits in the socket.
constexpr std::size_t kMostKept = 10'000;

std::atomic<bool> stop_requested = false;

void RequestStop(int) { stop_requested = true; }

void CatchStopSignals() {
  struct sigaction action = {};
  action.sa_handler = RequestStop;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

/// Runs a computation beside, and lets the process beat until it has ended. What arrives meanwhile
/// is appended to `kept`. A stop ends the program at once: nobody wants the result any more.
class LongRun {
 public:
  LongRun(Drive* drive, Bus* bus, std::function<Now()> clock, Usage (*usage)(), Beside* beside)
      : drive_(drive), bus_(bus), clock_(std::move(clock)), usage_(usage), beside_(beside) {}

  void Run(const std::function<void()>& computation) {
    beside_->Start(computation);
    if (beside_->EndsWithin(kBeatUs)) return;
    do {
      drive_->Beat(&kept_, clock_(), usage_);
    } while (!EndsBeforeBeat());
  }

  std::vector<Packet> TakeKept() { return std::exchange(kept_, {}); }

 private:
  bool EndsBeforeBeat() {
    const TimeUs until_us = MonotonicUs() + kBeatUs;
    while (MonotonicUs() < until_us) {
      if (stop_requested) std::_Exit(kExitOk);
      if (kept_.size() < kMostKept) {
        std::vector<Packet> arrived = bus_->Receive(kLookUs);
        std::move(arrived.begin(), arrived.end(), std::back_inserter(kept_));
        if (beside_->EndsWithin(0)) return true;
      } else if (beside_->EndsWithin(kLookUs)) {
        return true;
      }
    }
    return false;
  }

  Drive* drive_;
  Bus* bus_;
  std::function<Now()> clock_;
  Usage (*usage_)();
  std::vector<Packet> kept_;
  Beside* beside_;
};

}  // namespace

TimeUs MonotonicUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Now HostNow() {
  const auto wall = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  return {MonotonicUs(), wall.count()};
}

Usage HostUsage() {
  Usage usage;
  char host[HOST_NAME_MAX + 1] = {};
  if (gethostname(host, sizeof host - 1) == 0) usage.host = host;
  usage.pid = static_cast<std::int32_t>(getpid());
  rusage self = {};
  getrusage(RUSAGE_SELF, &self);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  usage.cpu_s = seconds(self.ru_utime) + seconds(self.ru_stime);
  usage.rss_bytes = self.ru_maxrss * 1024;
  return usage;
}

void AddRateOption(Options* options) {
  options->Add("rate", "R", "Mission seconds per wall second, or max")
      .Number({.low = 1e-3})
      .Or("max")
      .Default("max");
}

void AddProcessOptions(Options* options, std::string_view default_name) {
  options->Group("Process");
  options->Add("l,lcm-url", "URL", "LCM URL").Default(DefaultUrl());
  options->Add("name", "NAME", "Sender name of this process").Default(std::string(default_name));
  options->Add("run-id", "N", "Messages of other runs are ignored")
      .Integer(std::numeric_limits<std::int64_t>::min())
      .Default(1);
  options->Add("boot-id", "N", "How often this process was started before").Integer(0).Default(0);
  options
      ->Add("window", "N",
            "How many messages may be sent before the recorder has confirmed them; 0: there is no "
            "recorder")
      .Integer(0, std::numeric_limits<int>::max())
      .Default(0);
  options->Add(
      "key", "FILE",
      "The mission is sealed, and this is its key (docs/guide/seal.md); -: the first line of "
      "stdin");
  options->Add("drop", "P", "Share of received packets to drop, 0 to 1").Number({0, 1}).Default(0);
  options->Add("drop-seed", "N", "Seed of --drop").Seed().Default(1);
  options->Quiet();
}

ProcessFlags ReadProcessFlags(const Arguments& arguments, std::string_view only_name) {
  ProcessFlags flags;
  flags.identity.run_id = arguments.Get<std::int64_t>("run-id");
  flags.identity.name = arguments.Get("name");
  flags.identity.boot_id = arguments.Get<std::int64_t>("boot-id");
  flags.lcm_url = arguments.Get("lcm-url");
  flags.window = arguments.Get<int>("window");
  flags.drop = arguments.Get<double>("drop");
  flags.drop_seed = arguments.Get<std::uint64_t>("drop-seed");
  flags.quiet = arguments.Has("quiet");
  if (arguments.Has("key")) {
    flags.seal.emplace(Seal::Load(arguments.Get("key"), flags.identity.run_id));
    const MemberKeys* const members = flags.seal->members();
    const Member* const own = members ? members->Find(flags.identity.name) : nullptr;
    if (members != nullptr && (own == nullptr || !own->secret_key)) {
      throw InputError("command line", "--key", "a key of another process",
                       fmt::format("that of {}, as --name says", Printable(flags.identity.name)));
    }
  }
  if (HasControls(flags.identity.name)) {
    throw InputError("command line", "--name", Printable(flags.identity.name),
                     "a name without control characters");
  }
  if (!only_name.empty() && flags.identity.name != only_name) {
    throw InputError("command line", "--name", fmt::format("'{}'", flags.identity.name),
                     fmt::format("{}: the mission ignores any other", only_name));
  }
  return flags;
}

std::unique_ptr<LossyBus> OpenBus(const ProcessFlags& flags, GuardedChannels channels,
                                  std::optional<LcmTap> tap) {
  const bool recorder = tap.has_value();
  auto bus = std::make_unique<LossyBus>(
      std::make_unique<LcmBus>(flags.lcm_url, flags.seal ? flags.seal->tag_bytes() : 0,
                               std::move(tap), LcmBus::Reader::kOwnIfItCan, channels),
      flags.drop_seed, flags.identity.name, &MonotonicUs);
  if (recorder) bus->ReturnOnArrival();
  if (flags.seal) bus->SetSeal(*flags.seal);
  bus->SetFaults({.loss = flags.drop});
  return bus;
}

void StopProcesses() { stop_requested = true; }

int RunProcess(Process* process, LossyBus* bus, bool quiet, Usage (*usage)()) {
  CatchStopSignals();
  if (bus->proves_senders() && process->identity().name != process_name::kWorld) {
    process->StopRepeatingOthers();
  }
  Drive drive(process, bus);
  OutageWatch network;
  RefusalWatch refusals;
  const auto look_at_network = [&] {
    for (const auto& line :
         {network.Line(bus->Outage(), MonotonicUs()), refusals.Line(*bus, MonotonicUs())}) {
      if (line) fmt::print(stderr, "{}: {}\n", process->identity().name, *line);
    }
  };
  // Nobody can answer in an outage: its time does not count.
  const auto clock = [bus] {
    Now now = HostNow();
    now.monotonic_us -= bus->outage_us();
    return now;
  };
  // To the end of this thread: what a computation has started dies with the computation's thread
  // (PR_SET_PDEATHSIG).
  static thread_local Beside beside;
  LongRun long_run(&drive, bus, clock, usage, &beside);
  process->set_run_long(
      [&long_run](const std::function<void()>& computation) { long_run.Run(computation); });
  std::vector<Packet> arrived;
  while (!stop_requested) {
    const Now now = clock();
    if (drive.Turn(arrived, now, usage) && !quiet) {
      Say("{}: {}\n", process->identity().name, ToString(process->state()));
    }
    look_at_network();
    arrived = long_run.TakeKept();
    if (!arrived.empty()) continue;
    const TimeUs wait_us = drive.wake_us(now.monotonic_us) - clock().monotonic_us;
    arrived = bus->Receive(std::max<TimeUs>(wait_us, 0));
    look_at_network();
  }
  process->set_run_long({});
  return kExitOk;
}

}  // namespace muster
