#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/options.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/lossy_bus.h"
#include "protocol/process.h"

namespace muster {

/// Monotonic time, microseconds.
TimeUs MonotonicUs();
/// Both clocks of this host.
Now HostNow();
/// What the operating system knows of this process.
Usage HostUsage();

/// --rate of a mission: mission seconds per wall second, or max. One that is slower than a
/// thousandth of the wall's time is a slip, and its first tick would not come.
void AddRateOption(Options* options);

/// The flags that every mission process has.
struct ProcessFlags {
  Identity identity;
  std::string lcm_url;
  int window = 0;
  double drop = 0;
  std::uint64_t drop_seed = 0;
  bool quiet = false;
  std::optional<Seal> seal = {};
};

void AddProcessOptions(Options* options, std::string_view default_name);
/// Throws InputError on an impossible value. `only_name`: the name that the process
/// must have, because others ignore any other name on its channels (channels.h); "": any name.
ProcessFlags ReadProcessFlags(const Arguments& arguments, std::string_view only_name = "");

/// The bus of these flags: LCM, sealed as --key and lossy as --drop say. `channels`: what the
/// process hears. `tap`: a recorder's, which gets what arrives as it is.
std::unique_ptr<LossyBus> OpenBus(const ProcessFlags& flags,
                                  GuardedChannels channels = GuardedChannels::kOurs,
                                  std::optional<LcmTap> tap = {});

/// Drives a process over a bus until SIGINT or SIGTERM arrives: waits for packets or the process's
/// next wake, steps it, publishes what it says. Applies the faults on packets that MUSTER_FAULT
/// orders for it. `usage`: what it reports of itself. Returns the exit code. A program may run
/// several, each on a thread and a bus of its own.
int RunProcess(Process* process, LossyBus* bus, bool quiet, Usage (*usage)() = &HostUsage);
/// Ends RunProcess on all threads of this program, as SIGTERM does.
void StopProcesses();

}  // namespace muster
