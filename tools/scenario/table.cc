#include "tools/scenario/table.h"

#include <csv.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/text_file.h"

namespace muster::tools {
namespace {

constexpr std::size_t kMostTableBytes = std::size_t{4} << 30;

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

struct CsvSink {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
};

void TakeField(void* data, std::size_t size, void* sink) {
  static_cast<CsvSink*>(sink)->row.emplace_back(static_cast<const char*>(data), size);
}

void TakeRow(int, void* sink) {
  auto* csv = static_cast<CsvSink*>(sink);
  csv->rows.push_back(std::move(csv->row));
  csv->row.clear();
}

/// A property as a field of a table. Nested values are left empty.
std::string FieldOf(const JsonValue& value) {
  switch (value.type) {
    case JsonValue::Type::kNumber:
    case JsonValue::Type::kString:
      return value.text;
    case JsonValue::Type::kBoolean:
      return value.boolean ? "true" : "false";
    default:
      return "";
  }
}

bool HasText(const JsonValue* value, std::string_view text) {
  return value != nullptr && value->type == JsonValue::Type::kString && value->text == text;
}

/// Latitude and longitude of a Point feature; none for other geometries.
std::optional<std::pair<std::string, std::string>> PlaceOf(const JsonValue& feature) {
  const JsonValue* geometry = feature.Find("geometry");
  if (geometry == nullptr || !HasText(geometry->Find("type"), "Point")) return std::nullopt;
  const JsonValue* coordinates = geometry->Find("coordinates");
  if (coordinates == nullptr || coordinates->items.size() < 2) return std::nullopt;
  return std::pair{FieldOf(coordinates->items[1]), FieldOf(coordinates->items[0])};
}

}  // namespace

std::size_t Table::Column(std::string_view name) const {
  const auto at = std::find(columns.begin(), columns.end(), name);
  if (at == columns.end()) {
    throw InputError(file, "columns", fmt::format("no column '{}'", name),
                     fmt::format("one of {}", fmt::join(columns, ", ")));
  }
  return static_cast<std::size_t>(at - columns.begin());
}

std::string Table::RowName(std::size_t row) const {
  return is_geojson ? fmt::format("point {}", row + 1) : fmt::format("record {}", row + 2);
}

std::optional<std::string> Table::FirstOf(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    for (const std::string& column : columns) {
      if (Lower(column) == name) return column;
    }
  }
  return std::nullopt;
}

Table ParseCsv(std::string_view text, std::string_view file) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::string_view first = text.substr(0, text.find_first_of("\r\n"));
  unsigned char separator = CSV_COMMA;
  if (first.find(',') == first.npos) {
    if (first.find(';') != first.npos) separator = ';';
    if (first.find('\t') != first.npos) separator = CSV_TAB;
  }
  csv_parser parser;
  MUSTER_CHECK(csv_init(&parser, CSV_STRICT | CSV_STRICT_FINI) == 0);
  csv_set_delim(&parser, separator);
  CsvSink sink;
  const bool is_read =
      csv_parse(&parser, text.data(), text.size(), TakeField, TakeRow, &sink) == text.size() &&
      csv_fini(&parser, TakeField, TakeRow, &sink) == 0;
  const std::string error = csv_strerror(csv_error(&parser));
  csv_free(&parser);
  if (!is_read) {
    throw InputError(file, fmt::format("record {}", sink.rows.size() + 1),
                     fmt::format("malformed CSV ({})", error),
                     "fields in closed quotes or without any");
  }
  if (sink.rows.empty()) throw InputError(file, "content", "nothing", "a line of column names");

  Table table;
  table.file = file;
  table.columns = std::move(sink.rows.front());
  sink.rows.erase(sink.rows.begin());
  table.rows = std::move(sink.rows);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].size() > table.columns.size()) {
      throw InputError(file, fmt::format("record {}", i + 2),
                       fmt::format("{} fields", table.rows[i].size()),
                       fmt::format("{} as in the first line", table.columns.size()));
    }
    table.rows[i].resize(table.columns.size());
  }
  return table;
}

Table ParseGeoJson(std::string_view text, std::string_view file) {
  const JsonValue tree = ParseJson(text, file);
  std::vector<const JsonValue*> features;
  if (HasText(tree.Find("type"), "Feature")) {
    features.push_back(&tree);
  } else {
    const JsonValue* list = tree.Find("features");
    if (!HasText(tree.Find("type"), "FeatureCollection") || list == nullptr ||
        list->type != JsonValue::Type::kArray) {
      throw InputError(file, "top level", tree.Shown(),
                       "GeoJSON: a FeatureCollection with features, or a Feature");
    }
    for (const JsonValue& feature : list->items) features.push_back(&feature);
  }

  Table table;
  table.file = file;
  table.is_geojson = true;
  table.columns = {"latitude", "longitude"};
  std::map<std::string, std::size_t> columns;  // of the properties
  for (const JsonValue* feature : features) {
    const JsonValue* properties = feature->Find("properties");
    if (properties == nullptr) continue;
    for (const auto& [name, value] : properties->members) {
      if (name == "latitude" || name == "longitude") continue;  // the geometry's count
      if (columns.try_emplace(name, table.columns.size()).second) table.columns.push_back(name);
    }
  }
  for (const JsonValue* feature : features) {
    const auto place = PlaceOf(*feature);
    if (!place) {
      ++table.not_points;
      continue;
    }
    std::vector<std::string>& row = table.rows.emplace_back(table.columns.size());
    row[0] = place->first;
    row[1] = place->second;
    const JsonValue* properties = feature->Find("properties");
    if (properties == nullptr) continue;
    for (const auto& [name, value] : properties->members) {
      const auto column = columns.find(name);
      if (column != columns.end()) row[column->second] = FieldOf(value);
    }
  }
  return table;
}

Table ReadTable(const std::string& file) {
  const std::string text = ReadTextFile(file, "a table", kMostTableBytes);
  const std::string name = Lower(file);
  return name.ends_with(".json") || name.ends_with(".geojson") ? ParseGeoJson(text, file)
                                                               : ParseCsv(text, file);
}

}  // namespace muster::tools
