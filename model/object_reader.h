#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "base/json_tree.h"
#include "model/scenario.h"
#include "model/scenario_units.h"

namespace muster {

/// One object of a scenario file or an order, with its key path for messages. What it cannot read
/// is an InputError with file, key, value found and value expected.
class ObjectReader {
 public:
  ObjectReader(const JsonValue& value, std::string path, std::string_view file)
      : value_(value), path_(std::move(path)), file_(file) {
    if (value.type != JsonValue::Type::kObject) Fail("", value.Shown(), "an object");
  }

  /// Throws unless every key is one of `keys`.
  void AllowOnly(std::initializer_list<std::string_view> keys) const {
    for (const auto& [name, value] : value_.members) {
      if (std::find(keys.begin(), keys.end(), name) == keys.end()) {
        // Not as a key path: the name may hold anything.
        JsonValue shown;
        shown.type = JsonValue::Type::kString;
        shown.text = name;
        Fail("", "the unknown key " + shown.Shown(), fmt::format("only {}", fmt::join(keys, ", ")));
      }
    }
  }

  const JsonValue* Optional(std::string_view key) const { return value_.Find(key); }

  const JsonValue& Required(std::string_view key, std::string_view expected) const {
    const JsonValue* value = Optional(key);
    if (value == nullptr) Fail(key, "no such key", expected);
    return *value;
  }

  double Number(std::string_view key, Unit unit) const {
    return ReadNumber(key, Required(key, "a number"), unit);
  }

  double ReadNumber(std::string_view key, const JsonValue& value, Unit unit) const {
    if (value.type != JsonValue::Type::kNumber) Fail(key, value.Shown(), "a number");
    return FromText(value.text, unit);
  }

  TimeUs Time(std::string_view key, long double unit_us) const {
    const JsonValue& value = Required(key, "a number");
    const double amount = ReadNumber(key, value, kOne);
    const double most = kMaxMinutes * static_cast<double>(kMinute / unit_us);
    if (amount < 0 || amount > most) {
      Fail(key, value.Shown(), fmt::format("a number in [0, {}]", most));
    }
    return TimeFromText(value.text, unit_us);
  }

  std::int64_t Integer(std::string_view key, const JsonValue& value, std::int64_t low,
                       std::int64_t high) const {
    const double number =
        value.type == JsonValue::Type::kNumber ? FromText(value.text, kOne) : std::nan("");
    const bool is_integer = number == std::floor(number) && std::abs(number) <= 0x1p53;
    if (!is_integer || number < static_cast<double>(low) || number > static_cast<double>(high)) {
      Fail(key, value.Shown(), fmt::format("an integer in [{}, {}]", low, high));
    }
    return static_cast<std::int64_t>(number);
  }

  bool Boolean(std::string_view key, bool otherwise) const {
    const JsonValue* value = Optional(key);
    if (value == nullptr) return otherwise;
    if (value->type != JsonValue::Type::kBoolean) Fail(key, value->Shown(), "true or false");
    return value->boolean;
  }

  std::string String(std::string_view key) const {
    const JsonValue& value = Required(key, "a string");
    if (value.type != JsonValue::Type::kString) Fail(key, value.Shown(), "a string");
    return value.text;
  }

  const std::vector<JsonValue>& Array(std::string_view key) const {
    const JsonValue& value = Required(key, "an array");
    if (value.type != JsonValue::Type::kArray) Fail(key, value.Shown(), "an array");
    return value.items;
  }

  ObjectReader Child(std::string_view key) const {
    return ObjectReader(Required(key, "an object"), PathOf(key), file_);
  }
  ObjectReader Element(std::string_view list, const JsonValue& item, std::size_t index) const {
    return ObjectReader(item, fmt::format("{}[{}]", list, index), file_);
  }

  [[noreturn]] void Fail(std::string_view key, std::string_view found,
                         std::string_view expected) const {
    const std::string path = PathOf(key);
    throw InputError(file_, path.empty() ? "top level" : path, found, expected);
  }

 private:
  std::string PathOf(std::string_view key) const {
    if (key.empty()) return path_;
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
  }

  const JsonValue& value_;
  std::string path_;
  std::string_view file_;
};

/// What a task has in version 2 of the file only: times, priority, names.
void ReadTaskTimes(const ObjectReader& object, Task* task);

}  // namespace muster
