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

#include "base/check.h"
#include "base/program.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "protocol/drive.h"

namespace muster {
namespace {

std::atomic<bool> stop_requested = false;

void RequestStop(int) { stop_requested = true; }

void CatchStopSignals() {
  struct sigaction action = {};
  action.sa_handler = RequestStop;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

std::string_view NameOf(ProcessState state) {
  constexpr std::string_view kNames[] = {"starting", "ready", "running", "degraded", "ended"};
  return kNames[static_cast<int>(state)];
}

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

void AddProcessOptions(cxxopts::Options* options, const std::string& default_name) {
  options->add_options("Process")("l,lcm-url", "LCM URL",
                                  cxxopts::value<std::string>()->default_value(DefaultUrl()))(
      "name", "Sender name of this process",
      cxxopts::value<std::string>()->default_value(default_name))(
      "run-id", "Messages of other runs are ignored",
      cxxopts::value<std::int64_t>()->default_value("1"))(
      "boot-id", "How often this process was started before",
      cxxopts::value<std::int64_t>()->default_value("0"))(
      "window",
      "Messages that may be out unlogged: only with a recorder, which must be running; 0: none "
      "records",
      cxxopts::value<int>()->default_value("0"))("drop",
                                                 "Share of received packets to drop, 0 to 1",
                                                 cxxopts::value<double>()->default_value("0"))(
      "drop-seed", "Seed of --drop", cxxopts::value<std::uint64_t>()->default_value("1"))(
      "q,quiet", "Say nothing but errors");
}

ProcessFlags ReadProcessFlags(const cxxopts::ParseResult& result, std::string_view only_name) {
  ProcessFlags flags;
  flags.identity.run_id = result["run-id"].as<std::int64_t>();
  flags.identity.name = result["name"].as<std::string>();
  flags.identity.boot_id = result["boot-id"].as<std::int64_t>();
  flags.lcm_url = result["lcm-url"].as<std::string>();
  flags.window = result["window"].as<int>();
  flags.drop = result["drop"].as<double>();
  flags.drop_seed = result["drop-seed"].as<std::uint64_t>();
  flags.quiet = result.count("quiet") > 0;
  const auto require = [](bool holds, const char* key, const std::string& found,
                          const char* expected) {
    if (!holds) throw InputError("command line", key, found, expected);
  };
  require(flags.drop >= 0 && flags.drop <= 1, "--drop", fmt::to_string(flags.drop),
          "a share in [0, 1]");
  require(flags.window >= 0, "--window", fmt::to_string(flags.window), "0 or more");
  require(flags.identity.boot_id >= 0, "--boot-id", fmt::to_string(flags.identity.boot_id),
          "0 or more");
  require(!flags.identity.name.empty(), "--name", "nothing", "a name");
  if (!only_name.empty() && flags.identity.name != only_name) {
    throw InputError("command line", "--name", flags.identity.name,
                     fmt::format("{}: nobody listens to another", only_name));
  }
  return flags;
}

std::unique_ptr<LossyBus> OpenBus(const ProcessFlags& flags) {
  auto bus = std::make_unique<LossyBus>(std::make_unique<LcmBus>(flags.lcm_url), flags.drop_seed,
                                        flags.identity.name, &MonotonicUs);
  bus->SetFaults({.loss = flags.drop});
  return bus;
}

int RunProcess(Process* process, LossyBus* bus, bool quiet) {
  CatchStopSignals();
  Drive drive(process, bus);
  std::vector<Packet> arrived;
  while (!stop_requested) {
    const Now now = HostNow();
    if (drive.Turn(arrived, now, HostUsage) && !quiet) {
      fmt::print(stderr, "{}: {}\n", process->identity().name, NameOf(process->state()));
    }
    const TimeUs wait_us = drive.wake_us(now.monotonic_us) - MonotonicUs();
    arrived = bus->Receive(std::max<TimeUs>(wait_us, 0));
  }
  return kExitOk;
}

}  // namespace muster
