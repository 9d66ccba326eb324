#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/moment.h"
#include "tools/scenario/table.h"

namespace muster::tools {

/// What another system reports: tasks, each an object as in a task_add, and which of its earlier
/// reports it takes the place of. Without tasks it only takes those back.
struct Report {
  std::string key;                    ///< what the system calls this report
  std::string version;                ///< where it may change under its key: what is in it
  std::string sent;                   ///< orders the reports of one document; ISO 8601 or ""
  std::vector<std::string> replaces;  ///< keys
  std::vector<nlohmann::ordered_json> tasks;
};

/// The reports of a document, and why some of it are none.
struct Reports {
  std::vector<Report> reports;
  std::vector<std::string> refused;  ///< "FILE: alert NAME: key is value, expected ..."
};

/// The alerts of an XML document in the Common Alerting Protocol, version 1.1 or 1.2 (OASIS): one
/// alert, or several inside another document. Of each alert the areas with a circle or a polygon
/// become tasks at its centre (ours; docs/guide/feeds.md has the table of priorities). Only alerts
/// with `status` ("Actual", "Exercise") count. `start`: mission time 0; without it nothing expires.
/// Throws InputError naming `file` where it is no XML or has no alert.
Reports ReadCap(std::string_view xml, const std::string& file, std::string_view status,
                const std::optional<Moment>& start);

/// The submissions of a form in KoboToolbox's JSON: what its API answers, an array, or one. A
/// question "group/name" is the column "name". `columns`: empty where a submission lacks them, as
/// Kobo leaves out questions that were not answered. `task_of` makes a task of a table's only row.
/// Throws InputError naming `file` where it is no such JSON.
Reports ReadKobo(std::string_view json, const std::string& file,
                 const std::vector<std::string>& columns,
                 const std::function<nlohmann::ordered_json(const Table&)>& task_of);

/// The address of the next page of what Kobo's API answered; "" on the last one, and where this is
/// no such answer.
std::string NextPageOfKobo(std::string_view json);

}  // namespace muster::tools
