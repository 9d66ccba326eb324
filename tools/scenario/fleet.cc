#include "tools/scenario/fleet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "base/check.h"
#include "base/text.h"
#include "tools/scenario/fields.h"

namespace muster::tools {
namespace {

const std::vector<std::string> kClassNames = {"class", "kind", "type"};
const std::vector<std::string> kFleetLatitudes = {"latitude", "lat", "y"};
const std::vector<std::string> kFleetLongitudes = {"longitude", "lon", "lng", "long", "x"};
const std::vector<std::string> kFleetNumbers = {
    "speed_km_per_min", "full_range_km",    "range_km", "charge_km_per_min",
    "online_from_min",  "online_until_min", "capacity"};

/// The fields of a row, by the names of their columns.
class FleetRow {
 public:
  FleetRow(const Table& table, std::size_t row) : table_(table), row_(row) {}

  /// Of the first of these columns that there is; none: there is none, or it is blank here.
  std::optional<std::string> Text(const std::vector<std::string>& names) const {
    const auto column = table_.FirstOf(names);
    if (!column) return {};
    const std::string_view field = Trim(table_.rows[row_][table_.Column(*column)]);
    if (IsBlank(field)) return {};
    return std::string(field);
  }
  [[noreturn]] void Fail(const std::string& column, const std::string& found,
                         const std::string& expected) const {
    throw InputError(fmt::format("{}: {}", table_.file, table_.RowName(row_)), column, found,
                     expected);
  }
  std::optional<double> Number(const std::string& column, double least, bool more_than) const {
    const auto text = Text({column});
    if (!text) return {};
    const auto number = ToNumber(*text);
    if (!number || *number < least || (more_than && *number == least)) {
      Fail(column, *text, fmt::format("a number {} {}", more_than ? "above" : "from", least));
    }
    return number;
  }
  Origin Place() const {
    const auto degrees = [&](const char* what, const std::vector<std::string>& names,
                             double limit) {
      const auto text = Text(names);
      const auto value = text ? Degrees(*text, limit) : std::nullopt;
      if (!value) Fail(what, text.value_or("nothing"), fmt::format("degrees within {}", limit));
      return *value;
    };
    return {degrees("latitude", kFleetLatitudes, 90), degrees("longitude", kFleetLongitudes, 180)};
  }

 private:
  const Table& table_;
  const std::size_t row_;
};

/// As people write them, in any case of letters: "Drone", "Workers".
std::optional<AgentKind> ClassOf(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (text.size() > 1 && text.ends_with('s')) text.pop_back();
  if (text == "drone") return AgentKind::kUav;
  return FromString<AgentKind>(text);
}

FleetAgent ReadAgent(const FleetRow& row, const GeneratorSettings& settings,
                     const PerKind<std::size_t>& n) {
  const auto text = row.Text(kClassNames);
  const auto kind = text ? ClassOf(*text) : std::nullopt;
  if (!kind) row.Fail("class", text.value_or("nothing"), "uav, worker or vehicle");
  FleetAgent agent{*kind, row.Place(), DrawAgent(settings, 1, *kind, n[*kind])};
  AgentSpec& spec = agent.spec;
  if (const auto speed = row.Number("speed_km_per_min", 0, true)) {
    spec.speed_m_s = *speed * 1000 / 60;
  }
  if (*kind == AgentKind::kUav) {
    if (const auto full = row.Number("full_range_km", 0, true)) {
      spec.range_full_m = spec.range_m = *full * 1000;
    }
    if (const auto left = row.Number("range_km", 0, false)) spec.range_m = *left * 1000;
    if (spec.range_m > spec.range_full_m) {
      row.Fail("range_km", fmt::to_string(spec.range_m / 1000),
               fmt::format("at most the full range ({} km)", spec.range_full_m / 1000));
    }
  }
  if (*kind == AgentKind::kVehicle) {
    if (const auto rate = row.Number("charge_km_per_min", 0, true)) {
      spec.charge_rate_m_s = *rate * 1000 / 60;
    }
  }
  const auto minutes = [&](const char* column, TimeUs otherwise) {
    const auto number = row.Number(column, 0, false);
    return number ? ToUs(*number * 60) : otherwise;
  };
  spec.online_from_us = minutes("online_from_min", 0);
  spec.online_until_us = minutes("online_until_min", settings.rules.limit_us);
  if (spec.online_until_us < spec.online_from_us) {
    row.Fail("online_until_min", *row.Text({"online_until_min"}), "a time after online_from_min");
  }
  return agent;
}

void RequireRows(const Table& table, const char* what) {
  if (table.rows.empty()) throw InputError(table.file, "rows", "none", what);
}

}  // namespace

std::vector<std::string> UnusedColumns(const Table& table) {
  std::vector<std::string> unused;
  for (const std::string& column : table.columns) {
    Table alone;
    alone.columns = {column};
    const auto is_one_of = [&](const std::vector<std::string>& names) {
      return alone.FirstOf(names).has_value();
    };
    if (is_one_of(kClassNames) || is_one_of(kFleetLatitudes) || is_one_of(kFleetLongitudes) ||
        is_one_of(kFleetNumbers)) {
      continue;
    }
    unused.push_back(column);
  }
  return unused;
}

std::vector<FleetAgent> ReadFleet(const Table& table, const GeneratorSettings& settings) {
  RequireRows(table, "a row for each agent");
  std::vector<FleetAgent> fleet;
  PerKind<std::size_t> n;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    fleet.push_back(ReadAgent(FleetRow(table, i), settings, n));
    ++n[fleet.back().kind];
  }
  for (const AgentKind kind : kAgentKinds) {
    if (n[kind] > 0) continue;
    throw InputError(table.file, "class", fmt::format("no {}", ToString(kind)),
                     "at least one UAV, one worker and one vehicle");
  }
  return fleet;
}

std::vector<Depot> ReadDepots(const Table& table, const GeneratorSettings& settings) {
  RequireRows(table, "a row for each charging point");
  std::vector<Depot> depots;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const FleetRow row(table, i);
    Depot depot{row.Place(), settings.capacity};
    if (const auto text = row.Text({"capacity"})) {
      const auto capacity = ToInteger(*text, 1, 1'000'000);
      if (!capacity && *text != "none") {
        row.Fail("capacity", *text, "a whole number from 1, or none for no bound");
      }
      depot.capacity = capacity ? std::optional<int>(static_cast<int>(*capacity)) : std::nullopt;
    }
    depots.push_back(depot);
  }
  return depots;
}

}  // namespace muster::tools
