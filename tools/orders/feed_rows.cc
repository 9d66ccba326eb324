#include "tools/orders/feed_rows.h"

#include <fmt/format.h>

#include <map>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/sha256.h"
#include "base/text.h"
#include "tools/scenario/fields.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr TimeUs kDayUs = 24 * 60 * kMinuteUs;

std::optional<std::string> Find(const Table& table, const std::optional<std::string>& given,
                                const std::vector<std::string>& usual) {
  if (!given) return table.FirstOf(usual);
  table.Column(*given);
  return given;
}

}  // namespace

void Columns::CountFrom(const Moment& scenario_start) {
  FieldTime utc;
  utc.of_day_us = (scenario_start.unix_us % kDayUs + kDayUs) % kDayUs;
  utc.offset_min = 0;
  start = utc.On(scenario_start.offset_min).of_day_us;
  offset_min = scenario_start.offset_min;
}

RowReader::RowReader(const Table& head, Columns columns) : columns_(std::move(columns)) {
  columns_.latitude = Find(head, columns_.latitude, {"latitude", "lat", "y"});
  columns_.longitude = Find(head, columns_.longitude, {"longitude", "lon", "lng", "long", "x"});
  if (!columns_.latitude || !columns_.longitude) {
    throw InputError(head.file, "columns", fmt::format("{}", fmt::join(head.columns, ", ")),
                     "a latitude and a longitude (--lat, --lon)");
  }
  for (auto* column : {&columns_.time, &columns_.priority, &columns_.name, &columns_.note,
                       &columns_.external_id, &columns_.cost}) {
    if (*column) head.Column(**column);
  }
  if (columns_.time.has_value() != columns_.start.has_value()) {
    throw InputError("command line", columns_.time ? "--time" : "--start", "alone",
                     columns_.time ? "--start HH:MM, the mission's beginning, as its scenario "
                                     "has no start"
                                   : "--time COLUMN with --start HH:MM");
  }
}

Json RowReader::TaskOf(const Table& table, std::size_t row) const {
  const auto field = [&](const std::optional<std::string>& column) {
    return column ? std::string(Trim(table.rows[row][table.Column(*column)])) : std::string();
  };
  const auto refuse = [&](const std::string& column, const std::string& expected) {
    throw InputError(fmt::format("{}: {}", table.file, table.RowName(row)), column,
                     fmt::format("'{}'", field(column)), expected);
  };
  Json task;
  const auto latitude = Degrees(field(columns_.latitude), 90);
  const auto longitude = Degrees(field(columns_.longitude), 180);
  if (!latitude) refuse(*columns_.latitude, "degrees in [-90, 90]");
  if (!longitude) refuse(*columns_.longitude, "degrees in [-180, 180]");
  task["latitude_deg"] = *latitude;
  task["longitude_deg"] = *longitude;
  if (columns_.time) {
    auto time = ReadTime(field(columns_.time), DateOrder::kUnknown);
    if (!time) refuse(*columns_.time, "a time of day");
    if (columns_.offset_min) time = time->On(*columns_.offset_min);
    // A mission may go over midnight.
    task["reported_min"] = ToMinutes((time->of_day_us - *columns_.start + kDayUs) % kDayUs);
  }
  if (const std::string text = field(columns_.priority); !IsBlank(text)) {
    const auto priority = PriorityOf(text);
    if (!priority) refuse(*columns_.priority, "0 to 3, or low, normal, high or emergency");
    task["priority"] = static_cast<int>(*priority);
  }
  if (const std::string text = field(columns_.cost); !IsBlank(text)) {
    const auto cost = ToNumber(text);
    if (!cost) refuse(*columns_.cost, "km");
    task["cost_km"] = *cost;
  }
  if (const std::string text = field(columns_.name); !text.empty()) task["name"] = text;
  if (const std::string text = field(columns_.note); !text.empty()) {
    task["note"] = FirstBytes(text, kMostNote);
  }
  if (const std::string text = field(columns_.external_id); !text.empty()) {
    task["external_id"] = text;
  }
  if (!columns_.source.empty()) task["source"] = columns_.source;
  return task;
}

Json AddOrder(const std::string& id, const Json& task) {
  return {{"id", id}, {"issuer", "feed"}, {"order", "task_add"}, {"task", task}};
}

Reports ReadRows(const Table& table, const Columns& columns) {
  const RowReader reader(table, columns);
  std::map<std::string, int> n_seen;
  Reports reports;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    try {
      Report report;
      report.tasks.push_back(reader.TaskOf(table, row));
      const std::string content = Sha256(report.tasks[0].dump());
      const std::string id = report.tasks[0].value("external_id", "");
      report.key = id.empty() ? content : id;
      if (!id.empty()) report.version = content;
      if (const int n = n_seen[report.key]++; n > 0) report.key += fmt::format("#{}", n + 1);
      reports.reports.push_back(std::move(report));
    } catch (const InputError& error) {
      reports.refused.push_back(error.what());
    }
  }
  return reports;
}

}  // namespace muster::tools
