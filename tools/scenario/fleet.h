#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/generator.h"
#include "model/scenario.h"
#include "tools/scenario/table.h"

namespace muster::tools {

/// An agent that the user has, at its place on Earth.
struct FleetAgent {
  AgentKind kind = AgentKind::kUav;
  Origin place;
  AgentSpec spec;  ///< all but its place on the map
};

/// A charging point that the user has.
struct Depot {
  Origin place;
  std::optional<int> capacity = 1;  ///< none: unlimited
};

/// The agents of a table with a row each (docs/guide/import.md). What a row does not say is as in
/// `settings`; an agent is online for the whole mission unless its row says otherwise. Throws
/// InputError naming file, row, column, value and what was expected.
std::vector<FleetAgent> ReadFleet(const Table& table, const GeneratorSettings& settings);

/// Of a fleet's or depots' table, the columns that nothing is made of: a name that is spelt
/// otherwise would else go unnoticed.
std::vector<std::string> UnusedColumns(const Table& table);

/// The charging points of a table with a row each. Throws InputError in the same way.
std::vector<Depot> ReadDepots(const Table& table, const GeneratorSettings& settings);

}  // namespace muster::tools
