#include "tools/launch/mission_seal.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <optional>

#include "base/check.h"
#include "lcmtypes/bus/member_keys.h"
#include "tools/files/log_files.h"
#include "tools/launch/supervisor.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

using Senders = std::map<std::string, std::vector<std::string>>;

/// Sealed per process: the senders that each process is.
Senders SendersOf(const SealKey& key, const LaunchOptions& options,
                  const std::vector<ProcessPlan>& processes) {
  Senders senders;
  if (!key.per_process) return senders;
  for (const ProcessPlan& process : processes) {
    senders[process.name] = {process.name};
    if (!process.decides_as.empty()) senders[process.name].push_back(process.decides_as);
  }
  for (const auto& [kind, count] : options.processes) {
    const std::string by_hand(ToString(kind));
    if (count == 0) senders[by_hand] = {by_hand};
  }
  if (options.logger == Logger::kMuster)
    senders[process_name::kRecorder] = {process_name::kRecorder};
  if (!options.second_log.empty()) {
    senders[process_name::kSecondRecorder] = {process_name::kSecondRecorder,
                                              process_name::kSecondMarks};
  }
  return senders;
}

Seal SealOf(const SealKey& key, const LaunchOptions& options, const Scenario& scenario,
            const std::vector<ProcessPlan>& processes, const Senders& senders) {
  if (!key.per_process) return Seal(key);
  const std::string launcher(LauncherNameWith(options.logger));
  std::map<std::string, std::optional<AgentBlock>> members = {{launcher, {}}};
  for (const auto& [process, names] : senders) {
    for (const std::string& name : names) members[name];
  }
  for (const ProcessPlan& process : processes) members[process.name] = process.agents;
  for (const auto& [kind, count] : options.processes) {
    const auto n = static_cast<std::int32_t>(scenario.agents(kind).size());
    if (count == 0) members[std::string(ToString(kind))] = AgentBlock{kind, 0, n - 1};
  }
  return Seal(MemberKeys::Of(key.bytes, *key.run_id, launcher, members));
}

}  // namespace

MissionSeal::MissionSeal(const SealKey& key, const LaunchOptions& options, const Scenario& scenario,
                         const std::vector<ProcessPlan>& processes)
    : key_(key),
      senders_(SendersOf(key, options, processes)),
      seal_(SealOf(key, options, scenario, processes, senders_)) {}

std::string MissionSeal::KeyFor(const std::string& process) const {
  if (seal_.members() == nullptr) return key_.Text();
  return seal_.members()->Text(senders_.at(process));
}

void MissionSeal::Write(const RunDirectory& directory) const {
  directory.WriteSecret(kSealKeyFile, key_.Text());
  if (seal_.members() == nullptr) return;
  directory.Write(kSealPublicFile, seal_.members()->Text());
  std::error_code error;
  const std::string folder = directory.File(kProcessKeysFolder);
  fs::create_directories(folder, error);
  if (!error) fs::permissions(folder, fs::perms::owner_all, error);
  if (error) throw SystemError(fmt::format("cannot make {}: {}", folder, error.message()));
  for (const auto& [process, names] : senders_) {
    directory.WriteSecret(fmt::format("{}/{}.key", kProcessKeysFolder, process), KeyFor(process));
  }
}

}  // namespace muster::tools
