#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "base/json_tree.h"
#include "base/number_text.h"

namespace muster {

/// Strict reading of one JSON object: of a file, or of a line of a program. Anything
/// unreadable is an InputError that names the file, the key's path, line and column, what was found
/// and what was expected. The value and the name of the file must outlive the reader.
class ObjectReader {
 public:
  static constexpr double kMost = std::numeric_limits<double>::max();

  /// `path`: of this object in the file, "" for the top level. `file`: its name, or what messages
  /// call a text that is in no file, like "its line".
  ObjectReader(const JsonValue& value, std::string path, std::string_view file);

  /// Throws unless every key is one of `keys`.
  void AllowOnly(std::initializer_list<std::string_view> keys) const;

  bool Has(std::string_view key) const { return Optional(key) != nullptr; }
  /// The value of that key; nullptr where there is none.
  const JsonValue* Optional(std::string_view key) const { return value_.Find(key); }
  const JsonValue& Required(std::string_view key, std::string_view expected) const;

  /// A number in [low, high] of the file's unit, in ours.
  double Number(std::string_view key, Unit unit = kOne, double low = -kMost,
                double high = kMost) const;
  /// The same of a value that stands under `key`, such as an element of an array.
  double ReadNumber(std::string_view key, const JsonValue& value, Unit unit = kOne,
                    double low = -kMost, double high = kMost) const;
  /// A time of at least 0, in units of `unit_us`.
  TimeUs Time(std::string_view key, long double unit_us) const;
  std::int64_t Integer(std::string_view key, std::int64_t low, std::int64_t high) const;
  std::int64_t ReadInteger(std::string_view key, const JsonValue& value, std::int64_t low,
                           std::int64_t high) const;
  bool Boolean(std::string_view key, bool otherwise) const;
  std::string String(std::string_view key) const;
  const std::vector<JsonValue>& Array(std::string_view key) const;
  /// Throws unless that key is there and has that whole number, as a file's version must.
  void Expect(std::string_view key, std::int64_t number) const;

  ObjectReader Child(std::string_view key) const;
  /// Element `index` of the array under the key `list`, an object.
  ObjectReader Element(std::string_view list, const JsonValue& item, std::size_t index) const;

  [[noreturn]] void Fail(std::string_view key, std::string_view found,
                         std::string_view expected) const;
  /// Shows the value as it stands in the file, and where.
  [[noreturn]] void Fail(std::string_view key, const JsonValue& found,
                         std::string_view expected) const;

 private:
  std::string PathOf(std::string_view key) const;

  const JsonValue& value_;
  std::string path_;
  std::string_view file_;
};

}  // namespace muster
