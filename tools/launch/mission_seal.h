#pragma once

#include <map>
#include <string>
#include <vector>

#include "lcmtypes/bus/seal.h"
#include "tools/files/run_directory.h"
#include "tools/launch/launch_options.h"

namespace muster::tools {

/// A mission's seal, and the keys of its processes.
class MissionSeal {
 public:
  /// `key`: the run's. `processes`: all that the launcher starts but recorders.
  MissionSeal(const SealKey& key, const LaunchOptions& options, const Scenario& scenario,
              const std::vector<ProcessPlan>& processes);

  /// The launcher's.
  const Seal& seal() const { return seal_; }
  /// What that process gets on its stdin: a line.
  std::string KeyFor(const std::string& process) const;
  /// Writes the key into a run directory. Sealed per process: also what tells who has sent what,
  /// and the key of each process.
  void Write(const RunDirectory& directory) const;

 private:
  SealKey key_;
  /// The senders that each process is. Empty: all have the same key.
  std::map<std::string, std::vector<std::string>> senders_;
  Seal seal_;
};

}  // namespace muster::tools
