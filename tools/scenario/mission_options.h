#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/options.h"
#include "model/scenario.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// What `muster run` and `muster simulate` have in common.
struct MissionOptions {
  std::string scenario_file;
  std::string policy;
  bool own_policy = false;  ///< the user's scheduler knows it, we do not
  std::optional<double> interval_min;
  std::optional<double> limit_min;
  std::optional<std::uint64_t> seed;
  std::optional<Availability> availability;
  bool emergencies_at_once = false;  ///< false: as the scenario says
  std::string orders_file;           ///< "": no orders are given with the mission
  Room room = {};                    ///< for more of them
  std::string out;                   ///< "": the command's default
  bool quiet = false;
};

void AddMissionOptions(Options* options);
/// The scenario file and the overrides of its rules alone.
void AddRuleOptions(Options* options);
MissionOptions ReadRuleOptions(const Arguments& arguments);
/// Throws InputError on a policy that is none of ours, unless the scheduler has an `own_policy`.
MissionOptions ReadMissionOptions(const Arguments& arguments, bool own_policy = false);

/// Loads the scenario and puts the options' overrides into it. Throws InputError,
/// also when the policy cannot decide for such a scenario, and SystemError.
/// There is room for the orders of its file, which go to `orders`, for what is revisited and for
/// `room`.
Scenario ResolveScenario(const MissionOptions& options,
                         std::vector<world::PlannedOrder>* orders = nullptr);

}  // namespace muster::tools
