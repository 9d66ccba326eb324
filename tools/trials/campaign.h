#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "model/generator.h"
#include "model/scenario.h"
#include "tools/faults/random_plan.h"
#include "tools/simulate/virtual_mission.h"

namespace muster::tools {

/// What a drawn mission may have besides faults.
enum class Extra {
  kRoads,
  kZones,
  kOrders,
  kMeasured,
  kHosts,
  kClocks,
  kDecisions,
  kLateZones,
  kNotReady
};
inline constexpr std::array<std::string_view, 9> kExtraNames = {
    "roads",  "zones",     "orders",     "measured", "hosts",
    "clocks", "decisions", "late_zones", "not_ready"};

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
  /// A mission has each of these by chance. Hosts: with a process that is killed others die.
  /// Clocks: those of hosts are wrong by up to a day, or are set during the mission. Roads
  /// and zones are not added to a scenario that is given, but where it has them, they are closed
  /// and opened, added and lifted.
  /// Decisions: orders ask for some between intervals, or emergencies do.
  /// Not ready: of measured agents some say at times that they cannot set out yet.
  /// Late zones: where UAVs keep out of zones, nobody knows of some of them at first.
  std::set<Extra> extras = {Extra::kRoads,     Extra::kZones,     Extra::kOrders,
                            Extra::kMeasured,  Extra::kHosts,     Extra::kClocks,
                            Extra::kDecisions, Extra::kLateZones, Extra::kNotReady};
};

/// The mission of that seed: a function of settings and seed alone.
VirtualMission DrawMission(const CampaignSettings& settings, std::uint64_t seed);

/// Runs it, and says what of it breaks a promise; empty: nothing. It must end with its log
/// complete, at most three fifths of it repeats (five sevenths with several processes of a role and
/// losses), and each fault seen; the log must pass the audit, and its report agree with it; each
/// decision made again from the log must be the same; and where the mission waits for everybody,
/// and no agent is measured, decisions and outcomes must be those without any fault but those of
/// agents.
std::vector<std::string> FindingsOf(const VirtualMission& mission);

}  // namespace muster::tools
