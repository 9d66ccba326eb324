#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace muster::tools {

/// How a mission of the suite is run.
struct MissionSetting {
  std::string scenario_file;
  std::string policy;
  int processes = 1;  ///< of each agent class
  /// muster, lcm: over LCM, with that program writing the log; none: over LCM without a log;
  /// simulate: in one process.
  std::string run;
};

/// What all processes of one kind took.
struct KindUsage {
  double cpu_s = 0;
  std::int64_t peak_bytes = 0;  ///< of the largest of them
};

/// What one mission took.
struct MissionFigures {
  std::string end = "complete";  ///< or how else it ended, a few words without a comma
  double wall_s = 0;             ///< first to last clock; simulate: of the process
  double cpu_s = 0;              ///< of all its processes, from start to end
  /// By world, uav, worker, vehicle, scheduler, recorder, launcher, or simulate. lcm-logger tells
  /// nothing of itself: what it took is cpu_s without all of these.
  std::map<std::string, KindUsage> kinds;
  /// What the kernel counted in the mission's own network.
  std::int64_t sent_datagrams = 0, sent_bytes = 0;  ///< bytes: with IP and UDP headers
  std::int64_t received_datagrams = 0;              ///< by all sockets together
  std::int64_t buffer_errors = 0;  ///< not received, since the socket's buffer was full
  std::int64_t resent = 0;         ///< messages that their senders said again
  std::int64_t log_bytes = 0, log_messages = 0, log_doubles = 0;
  std::string digest;  ///< ""; none
};

/// Runs that mission in a network of its own and measures it; `folder`, which must be there, takes
/// its files and is left with them. Changes this process's network: in a process of its own only
/// (worker_pool.h), with one thread. Throws SystemError where no private network can be had.
MissionFigures RunMeasured(const MissionSetting& setting, const std::string& folder);

/// The number of that name in a table as of /proc/net/snmp: lines in pairs, names then numbers,
/// each behind its protocol. -1: it has none.
std::int64_t KernelCounter(std::string_view table, std::string_view protocol,
                           std::string_view name);

/// "uav" of "uav-12"; a name without a number stays as it is.
std::string KindOf(const std::string& process);

}  // namespace muster::tools
