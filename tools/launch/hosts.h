#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/faults/fault_plan.h"
#include "tools/host/child.h"

namespace muster::tools {

/// A host that runs some of a mission's processes.
struct Host {
  std::string name;
  std::string ssh;     ///< "user@machine"; "": this machine
  std::string netns;   ///< a network namespace of this machine (ip-netns(8)); "": ssh
  std::string folder;  ///< where that host has Muster's programs; "": where this one has them
  std::vector<std::string> processes;  ///< by sender name
  double mbit_s = 0;                   ///< what its link carries each way; 0: not known
  /// The host that gets its processes when it is gone; kHere: where `muster run` runs; "": none.
  std::string standby = {};
};

/// What the host of `muster run` is called.
inline constexpr std::string_view kHere = "here";

/// A host list, version 1 (docs/guide/hosts.md).
struct HostList {
  std::string lcm_url;
  std::vector<Host> hosts;

  /// The host of that process; nullptr: where `muster run` runs.
  const Host* Of(std::string_view process) const;
  /// Gives the processes of that host to its standby.
  void MoveToStandby(const std::string& host);
};

/// Throws InputError naming `file`, key, value and what is expected.
HostList ParseHosts(std::string_view json, const std::string& file);
HostList LoadHosts(const std::string& file);

/// Throws InputError where a host lists a process that the mission does not have, two hosts list
/// the same process, a standby is no other host, or the plan stops a process that no signal from
/// this machine reaches.
void CheckHosts(const HostList& list, const std::string& file,
                const std::vector<std::string>& processes, const FaultPlan& faults);

/// A word as a shell takes it unchanged.
std::string QuotedForShell(std::string_view word);

/// The same program, started on that host. argv[0] and its arguments reach it unchanged,
/// special characters included. Over ssh, the program ends when its ssh ends, and ssh with it.
ChildSpec OnHost(const Host& host, ChildSpec spec);

}  // namespace muster::tools
