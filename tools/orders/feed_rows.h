#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/moment.h"
#include "base/units.h"
#include "tools/orders/alert_feed.h"
#include "tools/scenario/table.h"

namespace muster::tools {

/// Which columns of a table say what.
struct Columns {
  std::optional<std::string> latitude, longitude, time, priority, name, note, external_id, cost;
  std::optional<TimeUs> start;    ///< time of day of the mission's beginning
  std::optional<int> offset_min;  ///< of the clocks that it was read from, where they are known
  std::string source;

  /// Times count from the scenario's start, on its clock.
  void CountFrom(const Moment& scenario_start);
};

/// Rows of a table as tasks.
class RowReader {
 public:
  /// Finds latitude and longitude by their usual names where `columns` does not name them. Throws
  /// InputError where a column is missing, or one of `time` and `start` stands alone.
  RowReader(const Table& head, Columns columns);

  /// An object as in a task_add. Throws InputError naming the row.
  nlohmann::ordered_json TaskOf(const Table& table, std::size_t row) const;

 private:
  Columns columns_;
};

/// The order that adds this task.
nlohmann::ordered_json AddOrder(const std::string& id, const nlohmann::ordered_json& task);

/// Each row as a report of its own. With a column of external ids, the rows of one id are the
/// versions of one report; without one a row is known by its task. Rows that are the same are told
/// apart by their order. Throws InputError where a column is missing.
Reports ReadRows(const Table& table, const Columns& columns);

}  // namespace muster::tools
