#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace muster::tools {

/// A table of text fields. Every row has a field for every column; a missing one is empty.
struct Table {
  std::string file;  ///< for messages
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::size_t not_points = 0;  ///< GeoJSON features that are no points, left out
  bool is_geojson = false;

  /// Index of the column of that name; throws InputError naming the columns that there are.
  std::size_t Column(std::string_view name) const;
  /// The row as messages name it: "record 2" is the first of a CSV file, "point 1" of GeoJSON.
  std::string RowName(std::size_t row) const;
  /// The first of the names that a column has, in any case of letters; none when no column has one.
  std::optional<std::string> FirstOf(const std::vector<std::string>& names) const;
};

/// Reads a CSV file (first line: column names; separated by commas, or by semicolons or tabs when
/// the first line has no comma) or, when its name ends in .json or .geojson, a GeoJSON file: each
/// Point feature is a row, its properties are columns and its place the columns "latitude" and
/// "longitude". Throws InputError when the content cannot be used, SystemError when it cannot be
/// read.
Table ReadTable(const std::string& file);

Table ParseCsv(std::string_view text, std::string_view file);
Table ParseGeoJson(std::string_view text, std::string_view file);

}  // namespace muster::tools
