#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "base/json_tree.h"
#include "tools/orders/alert_feed.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Nested values are left empty.
std::string TextOf(const JsonValue& value) {
  if (value.type == JsonValue::Type::kBoolean) return value.boolean ? "true" : "false";
  return value.text;
}

std::string Member(const JsonValue& object, std::string_view key) {
  const JsonValue* value = object.Find(key);
  return value == nullptr ? "" : TextOf(*value);
}

/// "uuid:81f2" and "81f2" are the same.
std::string WithoutScheme(const std::string& id) {
  return id.starts_with("uuid:") ? id.substr(5) : id;
}

Table RowOf(const JsonValue& submission, const std::string& where,
            const std::vector<std::string>& columns) {
  Table table;
  table.file = where;
  table.rows.emplace_back();
  const auto add = [&](const std::string& column, const std::string& value) {
    if (std::find(table.columns.begin(), table.columns.end(), column) != table.columns.end())
      return;
    table.columns.push_back(column);
    table.rows[0].push_back(value);
  };
  const JsonValue* place = submission.Find("_geolocation");
  const bool has_place = place != nullptr && place->items.size() == 2;
  add("latitude", has_place ? TextOf(place->items[0]) : "");
  add("longitude", has_place ? TextOf(place->items[1]) : "");
  for (const auto& [key, value] : submission.members) {
    add(key, TextOf(value));
    add(key.substr(key.rfind('/') + 1), TextOf(value));
  }
  for (const std::string& column : columns) add(column, "");
  return table;
}

}  // namespace

Reports ReadKobo(std::string_view json, const std::string& file,
                 const std::vector<std::string>& columns,
                 const std::function<Json(const Table&)>& task_of) {
  const JsonValue document = ParseJson(json, file);
  const JsonValue* results = document.Find("results");
  const bool is_one = document.Find("_uuid") != nullptr;
  const JsonValue& list = results != nullptr ? *results : document;
  if (!is_one && list.type != JsonValue::Type::kArray) {
    throw InputError(file, "content", document.Shown(),
                     "submissions of KoboToolbox: an array, or {\"results\": [...]}");
  }
  const std::vector<JsonValue> one = is_one ? std::vector{document} : std::vector<JsonValue>();
  const std::vector<JsonValue>& submissions = is_one ? one : list.items;
  Reports reports;
  for (std::size_t i = 0; i < submissions.size(); ++i) {
    const JsonValue& submission = submissions[i];
    const std::string where = fmt::format("{}: submission {}", file, i + 1);
    const std::string id = WithoutScheme(Member(submission, "_uuid"));
    if (id.empty()) {
      reports.refused.push_back(fmt::format("{}: it has no _uuid", where));
      continue;
    }
    try {
      Report report;
      report.key = id;
      report.sent = Member(submission, "_submission_time");
      const std::string before = WithoutScheme(Member(submission, "meta/deprecatedID"));
      if (!before.empty()) report.replaces.push_back(before);
      Json task = task_of(RowOf(submission, where, columns));
      if (!task.contains("external_id")) task["external_id"] = id;
      report.tasks.push_back(std::move(task));
      reports.reports.push_back(std::move(report));
    } catch (const InputError& error) {
      reports.refused.push_back(error.what());
    }
  }
  return reports;
}

std::string NextPageOfKobo(std::string_view json) {
  try {
    return Member(ParseJson(json, ""), "next");
  } catch (const InputError&) {
    return "";  // whoever reads the page itself says so
  }
}

}  // namespace muster::tools
