#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/generator.h"
#include "model/scenario.h"
#include "tools/faults/random_plan.h"
#include "tools/simulate/virtual_mission.h"

namespace muster::tools {

/// What the missions of a campaign have in common.
struct CampaignSettings {
  std::optional<Scenario> scenario;         ///< none: drawn
  std::optional<GeneratorSettings> preset;  ///< a scenario of it, drawn; none: its settings, too
  std::string policy;                       ///< "": drawn among quick ones
  double rate_per_hour = 6;                 ///< faults per mission hour, on average
  double drop = 0;                          ///< share of received packets that each process drops
  std::optional<int> schedulers;            ///< none: drawn, one to three
  std::vector<FaultKind> kinds = AllSurvivableKinds();
  std::optional<bool> goes_on;  ///< none: every other mission
};

/// The mission of that seed: a function of settings and seed alone.
VirtualMission DrawMission(const CampaignSettings& settings, std::uint64_t seed);

/// Runs it, and says what of it breaks a promise; empty: nothing. It must end with its log
/// complete, at most three fifths of it repeats, and each fault seen; the log must pass the audit,
/// and its report agree with it; each decision made again from the log must be the same; and where
/// the mission waits for everybody, decisions and outcomes must be those without any fault but
/// those of agents.
std::vector<std::string> FindingsOf(const VirtualMission& mission);

}  // namespace muster::tools
